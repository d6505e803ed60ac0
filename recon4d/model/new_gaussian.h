// A Gaussian as it is added to a set before anything is learnt of it: round, of one colour, at rest
// or in straight motion.
#pragma once
#include <cstdint>

#include "kernels/math/symmetric.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

struct NewGaussian {
  Vec3<float> position{0};  // world units, at its mean time
  Vec3<float> colour{0};    // RGB, [0, 1]
  float log_scale = 0;      // of world units
  double opacity = 0.1;
  // of a dynamic one
  float mean_time = 0;      // clip lengths
  double time_scale = 1;    // standard deviation, clip lengths
  Vec3<float> velocity{0};  // world units a clip length
};

/// Fills element n of a set in the host's memory, all of whose elements have the same K.
void write_gaussian(const NewGaussian& gaussian, GaussianSet& set, int64_t n);

}  // namespace tessera
