// A Tessera 4D file of one time as one model.
#pragma once
#include "static3d/tessera4d/windowed_file.h"

namespace tessera {

struct Tessera4dInput {
  GaussianModel model;  // dynamic set in velocity form
  Tessera4dManifest manifest;
  int64_t bytes = 0;
  std::vector<std::string> warnings;
};

inline Tessera4dInput load_tessera4d(const std::filesystem::path& path) {
  Tessera4dParts parts = open_tessera4d(path);
  GaussianModel model = parts.load(0);
  return {std::move(model), parts.manifest(), parts.bytes(), parts.warnings()};
}

}  // namespace tessera
