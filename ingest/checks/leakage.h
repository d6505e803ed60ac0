// Checks whether held-out images or views are also training images or views. Leakage through poses
// or the initial cloud cannot be detected from the files.
#pragma once
#include <filesystem>

#include "ingest/checks/finding.h"
#include "ingest/scene.h"

namespace tessera {

struct Leakage {
  int64_t training_frames = 0, held_out_frames = 0;
  int64_t same_images = 0;        // held-out images whose bytes are a training image's
  int64_t same_views = 0;         // held-out frames with pose and timestep of a training frame
  std::string training_manifest;  // FNV-1a of the names of the training frames, in order
  Findings findings;
};

/// `images`: the file of each frame of the scene, empty of a clip's; the scene needs no pixels.
/// Only files of equal size are read.
Leakage check_leakage(const Scene& scene, const std::vector<std::filesystem::path>& images);

}  // namespace tessera
