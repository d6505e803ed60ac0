// Snakemake as the engine of a batch on a cluster: a child process of `tessera batch` that runs
// `tessera job` for each job of OUT/jobs.json, by the Snakefile that is built into the program.
#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace tessera {

/// Its command line, engine first. `profile`: a folder of workflow/profiles, or a path; `jobs`: at
/// a time, 0: the profile's. Errors: InputError: Snakemake is not installed; no such profile (lists
/// those there are).
std::vector<std::string> engine_arguments(const std::filesystem::path& out,
                                          const std::string& profile, int64_t jobs);
/// Runs it to its end; its words go to `log`. It has a process group of its own, which gets one
/// SIGINT when `stop` becomes true: trainings write their checkpoints, the engine waits for them.
/// `tick` is called about ten times a second. Returns its exit code, 128 + signal where one ended
/// it. Errors: InputError: it cannot be started; WriteError: nor its log.
int run_engine(const std::vector<std::string>& arguments, const std::filesystem::path& log,
               const std::function<bool()>& stop, const std::function<void()>& tick);

/// Writes them below `folder`; scripts (#!) may be executed. A file that is there with the same
/// bytes is left alone. Errors: InputError: the folder cannot be written.
void write_workflow(const std::filesystem::path& folder);

/// The JSON texts of its tables (tables/NAME.json), by name.
std::map<std::string, std::string> workflow_tables();

}  // namespace tessera
