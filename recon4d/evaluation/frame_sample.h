// The training frames in the order in which a scoring pass draws them, so that the pass can end
// early: sweeps of equal share, each spread over all cameras and timesteps as evenly as possible.
#pragma once
#include <vector>

#include "ingest/scene.h"
#include "kernels/base/buffer.h"
#include "kernels/batch.h"
#include "kernels/math/colour_map.h"
#include "recon4d/model/clocks.h"

namespace tessera {

/// Frames [begin, end) of a sample.
struct FrameRange {
  int64_t begin = 0, end = 0;
};

/// Training frames and how they were exposed.
struct FrameSample {
  const Scene* scene = nullptr;
  /// Places in scene->frames, series by series; those of a series in the order of their timesteps.
  std::vector<int> frames;
  /// [frames] number of the series, which is the same cameras at several timesteps of a sweep.
  std::vector<int32_t> series;
  std::vector<FrameRange> sweeps;       // of `frames`, one behind another
  std::vector<ColourMap<double>> maps;  // [frames]; empty: the images are compared as rendered
  std::vector<CameraClock> clocks;      // [frames] added to what they state; empty: none
  KernelSwitches kernels;               // how they are drawn and looked at
  /// [frames] images and masks where the backend reads them; empty: those of the scene are copied.
  std::vector<Span<const uint8_t>> images, masks;
  /// [frames] masks with kMovingPixel, on the host; an empty one: of this frame it is not known
  /// what moves. Empty: of none.
  std::vector<Span<const uint8_t>> moving;

  int64_t count() const { return int64_t(frames.size()); }
  /// Frames that a pass draws as one batch: small images alone would leave a device idle.
  int64_t at_once() const;
  const Frame& frame(int64_t i) const { return scene->frames[size_t(frames[size_t(i)])]; }
  View view(int64_t i) const {
    const CameraClock clock = clocks.empty() ? CameraClock() : clocks[size_t(i)];
    return at_clock({frame(i).camera, frame(i).time, int32_t(frame(i).timestep), series[size_t(i)]},
                    clock);
  }
};

/// All training frames, which have numbers of timesteps. Of C cameras with T frames each, timestep
/// τ of camera c is in sweep
/// (τ + c′) mod S and there in series c mod S, where c′ is c mod S with its bits reversed: a sweep
/// has every timestep and every camera, where both are at least S. S is a power of two: as many
/// sweeps as leave each `least_frames`, and a series of several cameras three timesteps. Sweeps
/// come in an order in which the first 2^k of them are evenly spread, too. `maps`, `clocks` and
/// `images` are left empty.
FrameSample sample_training_frames(const Scene& scene, int64_t least_frames = 32);

}  // namespace tessera
