// Where several cameras of a rig miss a moving pixel at one timestep and agree on a place, a
// dynamic Gaussian that lasts about a frame is added there. Source: kernels/math/residual_vote.h.
#pragma once
#include <cstdint>

#include "recon4d/evaluation/frame_sample.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// In the form and layout of the dynamic set of `model`, the drawn one, in the host's memory: none
/// where it has no dynamic Gaussians or no three cameras with moving pixels share two timesteps.
/// `sample`: all training frames. `seed`: of the places inside their cubes.
GaussianSet spawn_missed(Backend& backend, const GaussianModel& model, const FrameSample& sample,
                         uint64_t seed);

}  // namespace tessera
