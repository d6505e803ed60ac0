// What is longer than one training is a list of jobs. A job is a command of this program, and the
// record that says that it is done.
#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tessera {

/// What a job takes of its machine while it runs.
struct JobUses {
  int64_t gpus = 0, threads = 1, memory_mb = 0;
};

struct Job {
  std::string name;                // of its list alone, and of its files
  std::vector<std::string> words;  // after the program
  std::vector<std::string> needs;  // names of jobs that are before it in the list
  std::string inputs;              // identifies what it reads beside their results
  JobUses uses;
};

/// Where the jobs of a list run, and what is written of them.
struct JobFolder {
  std::filesystem::path root;  // paths in the words of a job start here
  std::filesystem::path program;

  std::filesystem::path list() const { return root / "jobs.json"; }
  std::filesystem::path record(const std::string& name) const {
    return root / "jobs" / (name + ".json");
  }
  std::filesystem::path log(const std::string& name) const {
    return root / "logs" / (name + ".log");
  }
};

/// A record is {words, inputs, needs {name: at}, at, seconds, done, result}, or {…, exit_code,
/// message, out_of_memory} of a job that has failed; an empty object where there is none.
nlohmann::json read_record(const JobFolder& folder, const std::string& name);

/// Whether the job was done with these words and inputs, after what it needs.
bool is_done(const Job& job, const JobFolder& folder);

void write_job_list(const std::vector<Job>& jobs, const JobFolder& folder);
/// Errors: InputError: missing or damaged.
std::vector<Job> read_job_list(const JobFolder& folder);

}  // namespace tessera
