// Runs another program to its end, with an argument list instead of a shell. Its output goes to a
// log file and line by line to a callback; the program is ended when the call ends.
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
  std::vector<std::pair<std::string, std::string>> environment;  // added to this process's
  std::filesystem::path log;  // its output is appended here; empty: discarded
};

struct ChildResult {
  int exit_code = 0;      // 128 + signal where a signal ended it
  std::string last_line;  // the last that is not blank
};

/// Calls `on_line` for each line of stdout and stderr, and with an empty line ten times a second
/// while the child has no output; an exception of it ends the child and all processes of its group
/// (first SIGTERM, SIGKILL after a second) before it is passed on. Errors: InputError: the program
/// cannot be started; the log cannot be written (atomic_file.h).
ChildResult run_child(const ChildCommand& command,
                      const std::function<void(std::string_view)>& on_line);

/// The file that the shell would run for `name`: itself where it has a slash, else the first in
/// PATH that may be executed; an empty path where there is none.
std::filesystem::path find_program(const std::string& name);

}  // namespace tessera
