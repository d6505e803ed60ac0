// A whole clip as one .glb: meshes with KHR_gaussian_splatting under animated nodes, which programs
// play that read the extension and glTF animations. It is written only. Source: formats 1.7; glTF
// 2.0, 3.11 (animations).
#pragma once
#include <filesystem>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

struct MovingGlbReport {
  int64_t gaussians = 0;    // written
  int64_t groups = 0;       // animated nodes
  int64_t keys = 0;         // keyframes of the motion of canonical groups
  int64_t non_finite = 0;   // left out: a value not finite, a quaternion without length
  int64_t never_drawn = 0;  // left out: the marginal in time exceeds 1/2 at no time of the clip
  int64_t bytes = 0;
  double rms_motion_error = 0;    // of canonical means, shares of the scene's half extent
  double rms_velocity_error = 0;  // of dynamic means while visible, the same
};

/// Times are seconds from 0. Canonical Gaussians are in groups that move rigidly, with `fps`
/// keyframes a second, at least two; dynamic ones in groups of one velocity, which appear and
/// disappear at once. Directions of colours turn with a group. Errors: InputError: more bytes than
/// 32 bits count.
MovingGlbReport save_moving_glb(const std::filesystem::path& path, const GaussianModel& model,
                                double fps);

}  // namespace tessera
