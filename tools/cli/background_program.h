// Starts a program in a process group of its own, so that Ctrl-C does not reach it.
#pragma once
#include <sys/types.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// What a program is started with beside its words.
struct ProgramPlace {
  int output = STDOUT_FILENO, errors = STDERR_FILENO;  // open descriptors of this program
  std::filesystem::path folder = {};                   // that it works in; empty: this program's
  std::string variable = {};                           // of its environment, "NAME=value"
};

/// Starts `program` with `words`, [0] its name, and nothing to read. −1, with errno set, where it
/// cannot be started.
pid_t start_in_background(const std::filesystem::path& program,
                          const std::vector<std::string>& words, const ProgramPlace& place = {});

/// Words as they would be typed into a shell.
std::string shell_line(const std::vector<std::string>& words);

/// The file of this program.
std::filesystem::path this_program();

}  // namespace tessera
