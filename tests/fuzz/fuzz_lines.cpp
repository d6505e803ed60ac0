// Fuzz target: the readers of 4D splat files of other programs on arbitrary bytes. See
// scripts/fuzz.sh.
#include "static3d/line_motion/line_formats.h"
#include "tests/fuzz/hostile_file.h"
#include "tests/fuzz/zip_mutator.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return tessera::testing::read_hostile(data, size, ".lines", [](const auto& path) {
    if (tessera::is_line_file(path)) tessera::load_line_file(path);
  });
}
