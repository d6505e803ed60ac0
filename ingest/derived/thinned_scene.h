// A reduced scene for diagnosis: all frames without pixels, and a few frames with pixels.
#pragma once
#include <filesystem>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

struct Thinning {
  int instants = 5;    // of each station, spread over the clip
  int stations = 40;   // spread over the list; a rig has all of its cameras in general
  int largest = 1000;  // pixels; wider or higher images are reduced
};

struct ThinnedScene {
  Scene all;                                  // every frame, no pixels; the cloud
  Scene sample;                               // the chosen frames with pixels; the cloud
  std::vector<std::filesystem::path> images;  // of every frame of `all`; empty of a clip's
};

/// Errors: as load_scene.
ThinnedScene thinned_scene(const std::filesystem::path& folder, const Thinning& thinning);

}  // namespace tessera
