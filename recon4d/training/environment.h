// What: the environment that a training starts from.
// Not: what it is (kernels/math/environment.h), nor its steps (trainer.cpp).
#pragma once
#include "recon4d/model/gaussian_set.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Everywhere the mean colour of the training images, with zero moments. Errors: InputError:
/// frames with alpha, whose background is known and is no light from beyond the scene.
EnvironmentLight first_environment(const Scene& scene, const TrainOptions& options);

}  // namespace tessera
