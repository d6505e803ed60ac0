// Conversions between static and dynamic: a static set as a dynamic one whose two quaternions
// cancel in time, and a model at a timestep as a static set.
#pragma once
#include <algorithm>

#include "kernels/load_gaussian.h"
#include "static3d/transform/slicer.h"

namespace tessera::testing {

/// Each Gaussian without a velocity, mean_time 0.5 and the given temporal scale: it renders as
/// before at every t near [0, 1] when σ_t ≫ 1.
inline GaussianSet lift_to_4d(const GaussianSet& static_set, float log_scale_time,
                              SetForm form = SetForm::kPair) {
  constexpr float kMeanTimeOfLifted = 0.5f;
  GaussianSet lifted(form, static_set.coefficients());
  lifted.resize(static_set.count());
  const GaussianSpans<const float> from = static_set.values();
  const GaussianSpans<float> to = lifted.values();
  for (int g = 0; g < kStaticGroups; ++g)
    std::copy_n(from.group[g].data, from.group[g].size, to.group[g].data);
  for (int64_t n = 0; n < lifted.count(); ++n) {
    *to.at(kMeanTime, n) = kMeanTimeOfLifted;
    *to.at(kLogScaleTime, n) = log_scale_time;
    if (form == SetForm::kVelocity) {
      std::fill_n(to.at(kVelocity, n), 3, 0.0f);
      continue;
    }
    const Vec4<float> right = conjugate(load4(from.at(kRotation, n)));
    for (int k = 0; k < 4; ++k) to.at(kRotationRight, n)[k] = right[k];
  }
  return lifted;
}

inline GaussianSet slice_model(const GaussianModel& model, double time) {
  return Slicer(model).at(time);
}

}  // namespace tessera::testing
