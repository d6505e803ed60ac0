// Fuzz target: transforms.json as a camera path, on arbitrary bytes. See scripts/fuzz.sh.
#include "ingest/prepared/transforms_json.h"
#include "tests/fuzz/hostile_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return tessera::testing::read_hostile(data, size, ".json",
                                        [](const auto& path) { tessera::read_camera_path(path); });
}
