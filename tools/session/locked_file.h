// What: whether a file that was opened and locked still is the one of its name.
// Not: locks (run_lock.h, scene_lock.h).
#pragma once
#include <sys/stat.h>

#include <filesystem>

namespace tessera {

/// False where it was removed or exchanged between opening and locking.
inline bool is_file_of_name(int descriptor, const std::filesystem::path& file) {
  struct stat locked {
  }, named{};
  return ::fstat(descriptor, &locked) == 0 && ::stat(file.c_str(), &named) == 0 &&
         locked.st_ino == named.st_ino && locked.st_dev == named.st_dev;
}

}  // namespace tessera
