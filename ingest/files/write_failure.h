// What: whose failure it is when a file cannot be written: the path's (InputError) or the machine's
//       (WriteError).
// Not: writing (atomic_file.h).
#pragma once
#include <filesystem>
#include <stdexcept>

namespace tessera {

/// What had to be written could not be: the disk is full or broken. The message names the file,
/// what the system reported and the remedy, in one line. Exit code 1.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Whether errno `reason` speaks of the path that was given (no permission, not a folder, …) and
/// not of the machine (no space, an input/output error).
bool path_is_at_fault(int reason);

/// Errors: always: InputError where the path is at fault, else WriteError; the message names the
/// path, the reason (errno) and the remedy.
[[noreturn]] void fail_to_write(const std::filesystem::path& path, int reason);

}  // namespace tessera
