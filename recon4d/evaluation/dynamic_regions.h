// Which pixels of a camera that stands still show something that moves. Source: masked PSNR of the
// dynamic-scene literature.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "kernels/base/byte_medians.h"

namespace tessera {

/// Pixels whose truth differs from its median over time, in some channel, by more than kThreshold
/// and by more than noise does. The median is that of Scene::stills where the scene has them, and
/// what their masks ignore moves.
class DynamicRegions {
 public:
  static constexpr int kThreshold = kStillLimit;
  static constexpr size_t kMoments = 31;  // the median is of at most so many, spread over time
  static constexpr size_t kLeastMoments = 3;

  enum class Of { kAllFrames, kTrainingFrames };

  /// Medians of the cameras of `frames`, which are places in the scene. A training must not see
  /// test frames.
  DynamicRegions(const Scene& scene, Of of, const std::vector<int>& frames);

  /// [height, width] 255 where it moves, 0 elsewhere; empty: the camera moves, or has fewer than
  /// three timesteps. `frame`: of one of those cameras. May be called on several threads at once.
  std::vector<uint8_t> mask_of(const Frame& frame) const;
  /// Most that a still pixel of this camera differs by, 8-bit units.
  int threshold_of(const std::string& camera) const { return cameras_.at(camera).threshold; }

 private:
  struct StillCamera {
    std::vector<uint8_t> median;  // [height, width, 3], or empty
    FrameMask mask;               // ignores pixels that do not stand still over a longer clip
    int threshold = kThreshold;
  };
  std::map<std::string, StillCamera> cameras_;
};

}  // namespace tessera
