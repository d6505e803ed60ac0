// What: the two ways between static and dynamic: a Dim 3 set as Dim 4, a model at a timestep as
// Dim 3. Not: any decision which Gaussians should be which.
#pragma once
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Each Gaussian without a velocity, mean_time 0.5 and the given temporal scale: it renders as
/// before at every t near [0, 1] when σ_t ≫ 1. `form`: pair (rotation_right = conj(rotation)) or
/// velocity.
GaussianSet lift_to_4d(const GaussianSet& static_set, float log_scale_time,
                       Form form = Form::kPair);

/// The model at normalised time t as one static set: the static Gaussians unchanged, then each
/// dynamic one that is drawn at t with mean μ + vΔ, covariance Σ_c and opacity o·p. Those the
/// renderer would not draw (p < 0.05, o·p < 1/255) are left out. It renders as the model does at t
/// only when the model has sliced_direction: without, a moving Gaussian's colour is seen along the
/// direction of its mean over time, which the slice does not have.
GaussianSet slice_model(const GaussianModel& model, double time);

}  // namespace tessera
