// Fuzz target: JSON of cameras with K, D, R and T, on arbitrary bytes. See scripts/fuzz.sh.
#include <nlohmann/json.hpp>

#include "ingest/files/json_file.h"
#include "ingest/poses/rig_poses_file.h"
#include "tests/fuzz/hostile_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return tessera::testing::read_hostile(data, size, ".json", [](const auto& path) {
    std::vector<std::string> notes;
    tessera::rig_cameras_of(tessera::read_json(path), path, notes);
  });
}
