// Starts a program in a process group of its own, so that Ctrl-C does not reach it.
#pragma once
#include <sys/types.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// Starts `program` with `words`, [0] its name, and nothing to read. Its stdout is the open
/// descriptor `output` of this program. −1, with errno set, where it cannot be started.
pid_t start_in_background(const std::filesystem::path& program,
                          const std::vector<std::string>& words, int output = STDOUT_FILENO);

}  // namespace tessera
