// The values of a new Gaussian in each form of a set.
#include "recon4d/model/new_gaussian.h"

#include <algorithm>
#include <cmath>

#include "kernels/math/pair_at_velocity.h"
#include "kernels/math/splat.h"

namespace tessera {

void write_gaussian(const NewGaussian& gaussian, GaussianSet& set, int64_t n) {
  const GaussianSpans<float> v = set.values();
  for (int k = 0; k < 3; ++k) {
    v.at(kMean, n)[k] = gaussian.position[k];
    v.at(kLogScale, n)[k] = gaussian.log_scale;
    v.at(kSh, n)[k] = (gaussian.colour[k] - 0.5f) / float(kSh0);
  }
  std::fill_n(v.at(kSh, n) + 3, set.width(kSh) - 3, 0.0f);
  const float identity[4] = {1, 0, 0, 0};
  std::copy_n(identity, 4, v.at(kRotation, n));
  *v.at(kOpacityLogit, n) = logit(gaussian.opacity);
  if (set.dim() != 4) return;
  std::fill_n(v.at(kShTime, n), set.width(kShTime), 0.0f);
  *v.at(kMeanTime, n) = gaussian.mean_time;
  *v.at(kLogScaleTime, n) = float(std::log(gaussian.time_scale));
  if (set.form() == SetForm::kVelocity) {
    for (int k = 0; k < 3; ++k) v.at(kVelocity, n)[k] = gaussian.velocity[k];
    return;
  }
  const MovingPair pair = pair_at_velocity(std::exp(double(gaussian.log_scale)),
                                           gaussian.time_scale, Vec3<double>(gaussian.velocity));
  for (int k = 0; k < 3; ++k) v.at(kLogScale, n)[k] = float(pair.log_scale[k]);
  *v.at(kLogScaleTime, n) = float(pair.log_scale_time);
  for (int k = 0; k < 4; ++k) {
    v.at(kRotation, n)[k] = float(pair.left[k]);
    v.at(kRotationRight, n)[k] = float(pair.right[k]);
  }
}

}  // namespace tessera
