// Starts a program in a process group of its own, so that Ctrl-C does not reach it.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

enum class ProgramOutput { kShared, kToStderr };

/// Starts `program` with `words`, [0] its name, and nothing to read. −1, with errno set, where it
/// cannot be started.
pid_t start_in_background(const std::filesystem::path& program,
                          const std::vector<std::string>& words,
                          ProgramOutput output = ProgramOutput::kShared);

}  // namespace tessera
