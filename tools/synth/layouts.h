// Writes the images of a capture in one of the layouts, and the masks of what changes.
#pragma once
#include <filesystem>
#include <vector>

#include "tools/synth/ground_truth.h"
#include "tools/synth/synth.h"
#include "tools/synth/world.h"

namespace tessera::synth {

/// What every layout is written from; `folder` exists and holds a folder kTruthFolder.
struct CaptureJob {
  const SynthOptions& options;  // resolved
  const World& world;
  std::filesystem::path folder;
  const SynthProgress& progress;
};

/// transforms_train.json, _val, _test and their RGBA PNGs. Returns a view for each image.
std::vector<TrueView> write_dnerf(const CaptureJob& job);

/// camNN.mp4, for n3dv also poses_bounds.npy. Returns a view for each camera.
std::vector<TrueView> write_videos(const CaptureJob& job);

}  // namespace tessera::synth
