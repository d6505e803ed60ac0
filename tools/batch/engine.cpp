// Starts the engine in a process group of its own and polls waitpid. The assembler embeds the files
// of this folder, which CMakeLists.txt lists.
#include "tools/batch/engine.h"

#include <fcntl.h>
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
#include "ingest/files/folders.h"
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

/// A word of the workflow's own profiles, or a folder of the user's.
std::string profile_folder(const fs::path& out, const std::string& profile) {
  std::vector<std::string> shipped;
  for (const WorkflowFile& file : workflow_files())
    if (const fs::path path(file.path); path.filename() == "config.yaml")
      shipped.push_back(path.parent_path().filename());
  fs::path folder = profile;
  if (std::find(shipped.begin(), shipped.end(), profile) != shipped.end())
    folder = out / "workflow" / "profiles" / profile;
  else if (!fs::exists(folder / "config.yaml"))
    throw InputError(fmt::format(
        "--profile {}: no config.yaml in that folder and no profile of that name (there is {}); "
        "pass one of them or a folder with a config.yaml",
        profile, fmt::join(shipped, ", ")));
  folder = fs::absolute(folder).lexically_normal();
  if (folder.string().find_first_of(" \t\n") != std::string::npos)
    throw InputError(
        fmt::format("{}: Snakemake starts no scripts of a profile whose path has a space; choose "
                    "another folder",
                    folder.string()));
  return folder.string();
}

}  // namespace

std::vector<std::string> engine_arguments(const fs::path& out, const std::string& profile,
                                          int64_t jobs) {
  if (find_program(kSnakemake).empty())
    throw InputError(
        fmt::format("--profile {} needs snakemake, which is not installed; install it (apt-get "
                    "install snakemake), or leave this option out: the jobs run on this machine",
                    profile));
  std::vector<std::string> arguments{kSnakemake,
                                     "--snakefile",
                                     (out / "workflow" / "Snakefile").string(),
                                     "--directory",
                                     out.string(),
                                     "--profile",
                                     profile_folder(out, profile),
                                     "--keep-going",
                                     "--rerun-incomplete",
                                     "--nolock",  // the batch has a lock of its own
                                     "--config",
                                     "program=" + this_program().string()};
  if (jobs > 0) arguments.insert(arguments.end(), {"--jobs", fmt::format("{}", jobs)});
  return arguments;
}

int run_engine(const std::vector<std::string>& arguments, const fs::path& log,
               const std::function<bool()>& stop, const std::function<void()>& tick) {
  make_folder(log.parent_path());
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) fail_to_write(log, errno);
  const fs::path program = find_program(arguments.front());
  const pid_t child = start_in_background(program, arguments, {.output = file, .errors = file});
  const int reason = errno;
  ::close(file);
  if (child < 0)
    throw InputError(
        fmt::format("{}: cannot be started ({})", program.string(), std::strerror(reason)));
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
