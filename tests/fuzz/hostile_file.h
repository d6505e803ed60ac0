// Writes arbitrary bytes as a file for one reader and accepts the errors that a reader may throw.
#pragma once
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "kernels/base/errors.h"

namespace tessera::testing {

/// Writes the bytes to a file of that extension and hands its path to `read`. A reader accepts what
/// it is given or throws InputError; everything else (other exceptions too: out of memory, a failed
/// check) leaves through libFuzzer, which keeps the input.
template <class Read>
int read_hostile(const uint8_t* data, size_t size, const char* extension, Read&& read) {
  static const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("tessera_fuzz_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const std::filesystem::path path = folder / (std::string("input") + extension);
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr || std::fwrite(data, 1, size, file) != size || std::fclose(file) != 0)
    std::abort();  // no place to write: nothing is tested
  try {
    read(path);
  } catch (const InputError&) {
    // said in one line what is wrong
  }
  return 0;
}

}  // namespace tessera::testing
