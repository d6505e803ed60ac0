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
  int64_t gpus = 0, threads = 1, memory_mb = 0, minutes = 0;
};

struct Job {
  std::string name;                // of its list alone, and of its files
  std::vector<std::string> words;  // after the program
  std::vector<std::string> needs;  // names of jobs that are before it in the list
  std::string inputs;              // identifies what it makes, beside their results
  std::string output;   // below the root: the file that its JSON becomes; "": it is in the record
  std::string product;  // below the root: what is there when it is done; "": its output alone
  JobUses uses;
};

void to_json(nlohmann::json& json, const JobUses& uses);

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
/// message, out_of_memory} of a job that has failed; exit_code is null while it runs, and where its
/// end is not known. `seconds` are those of all starts that its result took. An empty object where
/// there is none.
nlohmann::json read_record(const JobFolder& folder, const std::string& name);

/// Whether the job was done with these inputs, after what it needs, and its files are there. How it
/// was done (its words: threads, places) does not count.
bool is_done(const Job& job, const JobFolder& folder);

/// Those that are not done, with all that need them, in their order.
std::vector<Job> jobs_to_do(const std::vector<Job>& jobs, const JobFolder& folder);

/// With the names of those that are to do.
void write_job_list(const std::vector<Job>& jobs, const JobFolder& folder);
/// Errors: InputError: missing or damaged.
std::vector<Job> read_job_list(const JobFolder& folder);

}  // namespace tessera
