// Fuzz target: JSON of cameras with K, D, R and T, on arbitrary bytes. See scripts/fuzz.sh.
#include "ingest/poses/rig_poses_file.h"
#include "tests/fuzz/hostile_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return tessera::testing::read_hostile(data, size, ".json",
                                        [](const auto& path) { tessera::read_rig_json(path); });
}
