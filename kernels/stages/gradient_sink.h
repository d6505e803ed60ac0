// What: where the gradient of a Gaussian goes: stored for later, or into Adam on the spot.
// The sink is the choice between a separate and a fused optimizer; kernels are templated on it.
// Not: schedules; step sizes come ready in AdamGroups.
#pragma once
#include "kernels/gaussians.h"
#include "kernels/math/spherical_harmonics.h"
#include "kernels/math/symmetric.h"

namespace tessera {

/// Gradient of one Gaussian by its stored parameters, summed over the views of a batch.
template <class Real>
struct ParameterGradient {
  Vec3<Real> mean{}, log_scale{};
  Vec4<Real> rotation{}, rotation_right{};
  Real opacity_logit{}, mean_time{}, log_scale_time{};
  Real sh[3 * kMaxShCoefficients] = {};

  /// Calls visit(group, scalars, width) for the groups of a set, `coefficients` of SH. Static, so
  /// that it serves constant and mutable gradients.
  template <int Dim, class Gradient, class Visit>
  TESSERA_HD static void for_each_group(Gradient& self, int coefficients, Visit&& visit) {
    visit(kMean, &self.mean[0], 3);
    visit(kLogScale, &self.log_scale[0], 3);
    visit(kRotation, &self.rotation[0], 4);
    visit(kOpacityLogit, &self.opacity_logit, 1);
    visit(kSh, self.sh, 3 * coefficients);
    if constexpr (Dim == 4) {
      visit(kMeanTime, &self.mean_time, 1);
      visit(kLogScaleTime, &self.log_scale_time, 1);
      visit(kRotationRight, &self.rotation_right[0], 4);
    }
  }
};

template <class Real>
struct StoreGradient {
  GaussianSpans<Real> out;

  template <int Dim>
  TESSERA_HD void accept(int64_t n, const ParameterGradient<Real>& gradient) const {
    ParameterGradient<Real>::template for_each_group<Dim>(
        gradient, out.coefficients, [&](Group group, const Real* g, int width) {
          for (int j = 0; j < width; ++j) out.at(group, n)[j] = g[j];
        });
  }
};

template <class Real>
struct ApplyAdam {
  GaussianSpans<Real> value, moment1, moment2;
  AdamGroups<Real> adam;

  template <int Dim>
  TESSERA_HD void accept(int64_t n, const ParameterGradient<Real>& gradient) const {
    ParameterGradient<Real>::template for_each_group<Dim>(
        gradient, value.coefficients, [&](Group group, const Real* g, int width) {
          Real *x = value.at(group, n), *m = moment1.at(group, n), *v = moment2.at(group, n);
          const int head = group == kSh ? min_of(width, 3) : width;
          for (int j = 0; j < head; ++j) adam_step(adam.group[group], g[j], x[j], m[j], v[j]);
          for (int j = head; j < width; ++j) adam_step(adam.sh_rest, g[j], x[j], m[j], v[j]);
        });
  }
};

}  // namespace tessera
