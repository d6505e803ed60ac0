// Fuzz target: the reader of the Tessera 4D .ply on arbitrary bytes. See scripts/fuzz.sh.
#include "recon4d/model/model_file.h"
#include "tests/fuzz/hostile_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return tessera::testing::read_hostile(data, size, ".ply",
                                        [](const auto& path) { tessera::load_model(path); });
}
