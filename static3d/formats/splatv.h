// The .splatv format of splaTV and gsplat.js: a whole model in one file, played in continuous time.
// It is written only, because it rounds values and drops the spherical harmonics. Source: formats 2
// (antimatter15/splaTV, MIT), written from its layout.
#pragma once
#include <filesystem>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/manifest.h"

namespace tessera {

struct SplatvReport {
  int64_t gaussians = 0;    // written
  int64_t non_finite = 0;   // left out: a value not finite, a quaternion without length
  int64_t never_drawn = 0;  // left out: not drawn at any timestep of the clip
  int64_t bytes = 0;
};

/// In front of the middle of the scene, along +z.
PlayerCamera splatv_camera(const GaussianModel& model);

/// Means to floats, everything else to half floats or bytes; colours seen along no direction (SH of
/// degree 0), those that follow time as they are at present where a Gaussian is brightest.
/// Players drop a Gaussian where its falloff in time is below 0.02, Tessera below 0.05. `cameras`:
/// at least one; players start at the first. Errors: InputError: more Gaussians than a texture of
/// players holds.
SplatvReport save_splatv(const std::filesystem::path& path, const GaussianModel& model,
                         const std::vector<PlayerCamera>& cameras);

}  // namespace tessera
