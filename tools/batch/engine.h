// Runs Snakemake, or the workflow's one_by_one.py where it is not installed, as a child process of
// `tessera batch`, and writes the workflow that is built into the program.
#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace tessera {

struct EngineRequest {
  std::filesystem::path out;      // absolute; has batch.yaml and workflow/
  std::string profile = "local";  // a folder of workflow/profiles, or a path
  int64_t jobs = 0;               // at a time; 0: the profile's, one on a single machine
  // of this machine, for profiles that run here
  int64_t cores = 1, gpus = 0, memory_mb = 0;
  bool dry_run = false;
  std::string file = "batch.yaml";  // in `out`
};

/// Whether the profile runs jobs on this machine.
bool runs_here(const EngineRequest& request);
/// The command line, engine first. Errors: InputError: no such profile (lists those there are).
std::vector<std::string> engine_arguments(const EngineRequest& request);
/// As it would be typed into a shell.
std::string shell_line(const std::vector<std::string>& arguments);

/// Whether it is in PATH. Without it the jobs run one after the other on this machine.
bool has_snakemake();
/// Errors: InputError: no engine in PATH that can do what is asked for, with how to install it.
void check_engine(const EngineRequest& request);

/// Runs it to its end; its words go where ours go. It has a process group of its own, which gets
/// one SIGINT when `stop` becomes true: trainings write their checkpoints, the engine waits for
/// them. `tick` is called about ten times a second. Returns its exit code, 128 + signal where one
/// ended it. Errors: InputError: it cannot be started.
int run_engine(const std::vector<std::string>& arguments, const std::function<bool()>& stop,
               const std::function<void()>& tick);

/// Writes them below `folder`; scripts (#!) may be executed. A file that is there with the same
/// bytes is left alone. Errors: InputError: the folder cannot be written.
void write_workflow(const std::filesystem::path& folder);

/// The JSON texts of its tables (tables/NAME.json), by name.
std::map<std::string, std::string> workflow_tables();

}  // namespace tessera
