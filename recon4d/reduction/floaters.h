// Floaters: faint, large Gaussians that one training camera alone shows. Nothing but that camera's
// images constrains them, so every other view sees them as haze. They are found by what each camera
// shows of each Gaussian, not by how they were trained. Source: failure mode F21.
#pragma once
#include <cstdint>
#include <vector>

#include "kernels/backend.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// What views show of each Gaussian of a model, [N] static set first. Sums run over pixels of the
/// blending weight T·α.
struct Support {
  /// Effective number of cameras that show it, (Σ_c W_c)² / Σ_c W_c² of the sums W_c; 0: none does.
  std::vector<float> cameras;
  /// Pixels that it covers with its opacity, as a share of the image of which it covers most.
  std::vector<float> extent;
};

/// The views of each camera, at the same timesteps for all of them: else what was drawn of one
/// camera alone would pass for what it alone can see.
using CameraViews = std::vector<std::vector<View>>;

/// Every place from which `training` views look, at every one of their timesteps; of both as many
/// as make about `most` views, evenly over them. Images are at most `longest` pixels wide and high:
/// floaters are large.
CameraViews views_of_support(const std::vector<View>& training, int64_t most = 384,
                             int longest = 400);

/// Draws every view once. Errors: as the backend.
Support measure_support(Backend& backend, const GaussianModel& model, const CameraViews& cameras);

/// Where a Gaussian is a floater: all three hold.
struct FloaterRule {
  float cameras = 2;      // fewer effective cameras than this
  float opacity = 0.5f;   // below this
  float extent = 0.005f;  // covers at least this share of an image
};

/// [N] static set first. A Gaussian that no view shows is none: nothing is known of it.
std::vector<uint8_t> find_floaters(const GaussianModel& model, const Support& support,
                                   const FloaterRule& rule = {});

/// Removes the elements of both sets that are marked, [N] static set first, and returns how many
/// there were. The model lies on the host.
int64_t remove_marked(const std::vector<uint8_t>& marked, GaussianModel& model);

}  // namespace tessera
