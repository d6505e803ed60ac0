// What: runs another program to its end: argv without a shell, its words to a log file and to a
//       callback line by line, and it never outlives the call.
// Not: what any program's words mean (ingest/colmap/colmap_program.h).
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera {

struct ChildCommand {
  std::vector<std::string> arguments;                            // [0]: the program's path
  std::vector<std::pair<std::string, std::string>> environment;  // beyond our own
  std::filesystem::path log;  // what it says is added here; empty: kept nowhere
};

struct ChildResult {
  int exit_code = 0;      // 128 + signal where a signal ended it
  std::string last_line;  // the last that is not blank
};

/// Calls `on_line` for each line of stdout and stderr, and with an empty line ten times a second
/// while the child is silent; what it throws ends the child and all processes of its group (first
/// SIGTERM, SIGKILL after a second) before it is passed on. Errors: InputError: the program cannot
/// be started; the log cannot be written (atomic_file.h).
ChildResult run_child(const ChildCommand& command,
                      const std::function<void(std::string_view)>& on_line);

/// The file that the shell would run for `name`: itself where it has a slash, else the first in
/// PATH that may be executed; an empty path where there is none.
std::filesystem::path find_program(const std::string& name);

}  // namespace tessera
