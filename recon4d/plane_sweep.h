// What: initial points of a calibrated rig without a point cloud: each a pixel of a training
// picture
//       at the depth where the other cameras of the same moment agree with it.
// Not: dense stereo, and no monocular captures: there no two cameras share a moment.
// Source: plane sweep after [Collins96], patches compared by mean absolute difference.
#pragma once
#include <cstdint>
#include <vector>

#include "recon4d/camera_rig.h"

namespace tessera {

/// A point with what the pictures say about it.
struct SweptPoint {
  glm::vec3 position;             // world units
  std::array<uint8_t, 3> colour;  // of the picture it was found in
  float time;                     // normalised moment of that picture
  bool still;                     // that pixel looks the same at other moments of the clip
};

/// Tries `candidates` random pixels; those without texture, agreement or a distinct best depth give
/// no point. Empty when fewer than three training cameras share a moment.
std::vector<SweptPoint> plane_sweep(const Scene& scene, const CameraRig& rig, int64_t candidates,
                                    uint64_t seed);

}  // namespace tessera
