// Pixels of a static camera that look the same at nearly all times, up to brightness. The
// brightness of a frame is the median over pixels of its ratio to another frame.
#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "kernels/math/patch.h"

namespace tessera {

/// Brightness of an image's channels by that of another image of its camera.
using LightRatio = std::array<float, 3>;

/// Median over pixels of (a + 1) / (b + 1), channel by channel, between a half and two. Images of
/// equal size, RGB.
LightRatio light_ratio(const Image8& a, const Image8& b);

/// Takes only a few numbers of memory for each image.
class StillPixels {
 public:
  /// By the training frames of `over_time`, which have images. It must outlive this.
  explicit StillPixels(const Scene& over_time);
  /// By the camera's first frame of those; 1 where it has none, or stood elsewhere then.
  LightRatio light_of(const Frame& frame) const;
  /// Up to eight frames of its camera, the first and the last among them, each with the light of
  /// this frame by its own; none of a camera that no frame is known of. `light`: light_of(frame).
  std::vector<StillSight> sights_of(const Frame& frame, const LightRatio& light) const;

 private:
  struct Sight {
    const Frame* frame;
    LightRatio light;  // by the first of the camera
  };
  std::map<std::string, std::vector<Sight>> cameras_;
};

}  // namespace tessera
