// Starts the engine in a process group of its own and polls waitpid. The assembler embeds the files
// of this folder, which CMakeLists.txt lists.
#include "tools/batch/engine.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <string_view>
#include <thread>

#include "ingest/files/atomic_file.h"
#include "ingest/files/child_process.h"
#include "kernels/base/errors.h"
#include "tools/cli/background_program.h"

#define WORKFLOW_FILE(number, path, source)                  \
  asm(".pushsection .rodata\n"                               \
      ".global tessera_workflow_" #number                    \
      "_begin\n"                                             \
      ".global tessera_workflow_" #number                    \
      "_end\n"                                               \
      "tessera_workflow_" #number                            \
      "_begin:\n"                                            \
      ".incbin \"" source                                    \
      "\"\n"                                                 \
      "tessera_workflow_" #number                            \
      "_end:\n"                                              \
      ".byte 0\n"                                            \
      ".popsection\n");                                      \
  extern "C" const char tessera_workflow_##number##_begin[]; \
  extern "C" const char tessera_workflow_##number##_end[];
#include "tools/batch/workflow_table.inc"
#undef WORKFLOW_FILE

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr const char* kSnakemake = "snakemake";
constexpr const char* kPython = "python3";

std::string profiles_there(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.is_directory(ignored)) names.push_back(entry.path().filename().string());
  return names.empty() ? "none is there" : fmt::format("there are {}", fmt::join(names, ", "));
}

/// A word of the workflow's own profiles, or a folder of the user's.
std::string profile_folder(const EngineRequest& request) {
  const fs::path shipped = request.out / "workflow" / "profiles" / request.profile;
  if (request.profile.find('/') == std::string::npos && fs::exists(shipped / "config.yaml"))
    return shipped.string();
  if (fs::exists(fs::path(request.profile) / "config.yaml"))
    return fs::absolute(request.profile).lexically_normal().string();
  throw InputError(fmt::format(
      "--profile {}: no config.yaml in that folder and no profile of that name ({}); pass one of "
      "them or a folder with a config.yaml",
      request.profile, profiles_there(shipped.parent_path())));
}

pid_t start(const std::vector<std::string>& arguments) {
  const fs::path program = find_program(arguments.front());
  const pid_t child = start_in_background(program, arguments);
  if (child < 0)
    throw InputError(
        fmt::format("{}: cannot be started ({})", program.string(), std::strerror(errno)));
  return child;
}

struct WorkflowFile {
  std::string_view path;  // below the workflow's folder: "Snakefile", "profiles/slurm/config.yaml"
  std::string_view bytes;
};

const std::vector<WorkflowFile>& workflow_files() {
#define WORKFLOW_FILE(number, path, source) \
  {path,                                    \
   {tessera_workflow_##number##_begin,      \
    size_t(tessera_workflow_##number##_end - tessera_workflow_##number##_begin)}},
  static const std::vector<WorkflowFile> files = {
#include "tools/batch/workflow_table.inc"
  };
#undef WORKFLOW_FILE
  return files;
}

}  // namespace

bool runs_here(const EngineRequest& request) {
  return request.profile == "local";
}

namespace {

std::vector<std::string> snakemake_arguments(const EngineRequest& request) {
  const std::string profile = profile_folder(request);
  if (!runs_here(request) && profile.find_first_of(" \t\n") != std::string::npos)
    throw InputError(fmt::format(
        "{}: Snakemake starts no scripts of a profile whose path has a space; choose another OUT",
        profile));
  std::vector<std::string> arguments{
      kSnakemake,    "--snakefile",        (request.out / "workflow" / "Snakefile").string(),
      "--directory", request.out.string(), "--profile",
      profile,       "--keep-going",       "--rerun-incomplete",
      "--nolock"};  // the workflow has a lock of its own
  if (runs_here(request)) {
    const int64_t gpus = std::max<int64_t>(request.gpus, 1);
    arguments.insert(arguments.end(),
                     {"--cores", fmt::format("{}", request.cores), "--resources",
                      fmt::format("gpu={}", gpus), fmt::format("mem_mb={}", request.memory_mb)});
  } else if (request.jobs > 0) {
    arguments.insert(arguments.end(), {"--jobs", fmt::format("{}", request.jobs)});
  }
  if (request.dry_run)
    arguments.insert(arguments.end(), {"--dry-run", "--config", "file=" + request.file});
  return arguments;
}

/// Of the workflow's own driver; threads and GPUs are in batch.yaml.
std::vector<std::string> one_by_one_arguments(const EngineRequest& request) {
  std::vector<std::string> arguments{kPython, (request.out / "workflow" / "one_by_one.py").string(),
                                     "--directory", request.out.string()};
  if (request.dry_run) arguments.insert(arguments.end(), {"--dry-run", "--file", request.file});
  return arguments;
}

}  // namespace

std::vector<std::string> engine_arguments(const EngineRequest& request) {
  return has_snakemake() ? snakemake_arguments(request) : one_by_one_arguments(request);
}

std::string shell_line(const std::vector<std::string>& arguments) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./=,:+@%";
  const auto quoted = [](const std::string& argument) {
    std::string word;
    for (char c : argument) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return fmt::format("'{}'", word);
  };
  std::vector<std::string> words;
  for (const std::string& argument : arguments) {
    const bool plain = !argument.empty() && argument.find_first_not_of(kPlain) == std::string::npos;
    words.push_back(plain ? argument : quoted(argument));
  }
  return fmt::format("{}", fmt::join(words, " "));
}

bool has_snakemake() {
  return !find_program(kSnakemake).empty();
}

void check_engine(const EngineRequest& request) {
  constexpr const char* kNeeded =
      "{} needs snakemake, which is not installed; install it (apt-get install snakemake), or "
      "leave this option out: the jobs run one after the other here";
  if (has_snakemake()) return;
  if (!runs_here(request)) throw InputError(fmt::format(kNeeded, "--profile " + request.profile));
  if (request.jobs > 1)
    throw InputError(fmt::format(kNeeded, fmt::format("--jobs {}", request.jobs)));
  if (find_program(kPython).empty())
    throw InputError(
        "python3 is not installed, which runs batches; install it (apt-get install python3)");
}

int run_engine(const std::vector<std::string>& arguments, const std::function<bool()>& stop,
               const std::function<void()>& tick) {
  const pid_t child = start(arguments);
  bool told = false;
  int status = 0;
  while (true) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) break;
    if (ended < 0 && errno != EINTR) return 1;
    if (stop() && !told) {
      ::kill(-child, SIGINT);
      told = true;
    }
    tick();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

void write_workflow(const fs::path& folder) {
  for (const WorkflowFile& file : workflow_files()) {
    const fs::path target = folder / file.path;
    if (!fs::is_regular_file(target) || read_text_file(target) != file.bytes)
      write_text_file(target, file.bytes);
    if (file.bytes.starts_with("#!"))
      fs::permissions(target,
                      fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec,
                      fs::perm_options::add);
  }
}

std::map<std::string, std::string> workflow_tables() {
  std::map<std::string, std::string> tables;
  for (const WorkflowFile& file : workflow_files())
    if (const fs::path path(file.path); path.parent_path() == "tables")
      tables.emplace(path.stem(), file.bytes);
  return tables;
}

}  // namespace tessera
