// The first Gaussians of a training, from a point cloud or at random, and the first environment.
// Source: method A.2, D.4, D.8.
#pragma once
#include <string>
#include <vector>

#include "kernels/base/camera_rig.h"
#include "recon4d/model/gaussian_set.h"
#include "recon4d/options/train_options.h"

namespace tessera {

struct Initialisation {
  GaussianModel model;
  std::string source;  // "point cloud, 1,656 points" or "random, 20,000 points in view"
};

/// Dim 4 Gaussians unless the scene or the options are static. `shared`: the static set that the
/// model has, which a training leaves as it is; null: still points become one. Beside it all are
/// dynamic, still ones for the whole clip, without those that it shows already. Errors: InputError
/// when no point remains (all carved away).
Initialisation initialise_model(const Scene& scene, const CameraRig& rig,
                                const TrainOptions& options, const GaussianSet* shared = nullptr);

/// Everywhere the mean colour of the training images, with zero moments. Errors: InputError:
/// frames with alpha, whose background is known and is no environment.
EnvironmentLight first_environment(const Scene& scene, const TrainOptions& options);

}  // namespace tessera
