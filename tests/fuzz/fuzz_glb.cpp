// Fuzz target: the reader of .glb on arbitrary bytes. See scripts/fuzz.sh.
#include "static3d/formats/splat_file.h"
#include "tests/fuzz/hostile_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return tessera::testing::read_hostile(data, size, ".glb",
                                        [](const auto& path) { tessera::load_splat_file(path); });
}
