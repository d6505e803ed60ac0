// The facts of a model for `tessera info`, as JSON.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// num_gaussians, num_static, num_dynamic, num_unsound (a value not finite, a quaternion without
/// length), sh_degree, sh_coefficients of each set, value_bytes, bounds of the means (of the sound
/// ones; null when there are none), percentiles of opacity, scale, temporal_extent (σ_t, normalised
/// time) and speed (world units per unit of normalised time), time_axis, background, clip_planes.
nlohmann::json model_info(const GaussianModel& model);

}  // namespace tessera
