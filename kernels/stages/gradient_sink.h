// The destinations of the gradient of a Gaussian: StoreGradient keeps it for a separate optimizer,
// ApplyAdam applies it at once. Kernels are templated on the sink. AdamGroups hold the finished
// step sizes; the traversal chooses the Gaussians (IdleUpdate).
#pragma once
#include <type_traits>

#include "kernels/gaussians.h"
#include "kernels/math/adam.h"
#include "kernels/math/symmetric.h"

namespace tessera {

/// Bit (1 << group) for each group of a gradient with a value that is not finite.
template <SetForm form, class Gradient>
TESSERA_HD inline unsigned non_finite_groups(const Gradient& gradient) {
  unsigned bits = 0;
  Gradient::template for_each_group<form>(gradient, [&](Group group, const auto* g, int width) {
    auto sum = g[0] - g[0];
    for (int j = 1; j < width; ++j) sum += g[j] - g[j];
    if (!(sum == 0)) bits |= 1u << group;
  });
  return bits;
}

/// Gradient of one Gaussian by all that is stored of it but SH, summed over the views of a batch.
/// What motion nodes carry of a canonical one is in CarriedGradient.
template <class Real>
struct GeometryGradient {
  Vec3<Real> mean{}, log_scale{};
  Vec4<Real> rotation{}, rotation_right{};  // right: of a pair
  Vec3<Real> velocity{};                    // of a velocity set
  Real opacity_logit{}, mean_time{}, log_scale_time{};

  /// Calls visit(group, scalars, width) for the groups of a set. Static, so that it serves constant
  /// and mutable gradients.
  template <SetForm form, class Gradient, class Visit>
  TESSERA_HD static void for_each_group(Gradient& self, Visit&& visit) {
    if constexpr (form != SetForm::kCanonical) visit(kMean, &self.mean[0], 3);
    visit(kLogScale, &self.log_scale[0], 3);
    if constexpr (form != SetForm::kCanonical) visit(kRotation, &self.rotation[0], 4);
    visit(kOpacityLogit, &self.opacity_logit, 1);
    if constexpr (is_dynamic(form)) {
      visit(kMeanTime, &self.mean_time, 1);
      visit(kLogScaleTime, &self.log_scale_time, 1);
    }
    if constexpr (form == SetForm::kPair) visit(kRotationRight, &self.rotation_right[0], 4);
    if constexpr (form == SetForm::kVelocity) visit(kVelocity, &self.velocity[0], 3);
  }
};

/// Gradient of one canonical Gaussian by what motion nodes carry of it and by their logits.
template <class Real>
struct CarriedGradient {
  Vec3<Real> mean{};
  Vec4<Real> rotation{};
  Real node_logit[kBindings] = {};

  template <SetForm form, class Gradient, class Visit>
  TESSERA_HD static void for_each_group(Gradient& self, Visit&& visit) {
    static_assert(form == SetForm::kCanonical);
    visit(kMean, &self.mean[0], 3);
    visit(kRotation, &self.rotation[0], 4);
    visit(kNodeLogit, self.node_logit, kBindings);
  }
};

template <class Real>
struct StoreGradient {
  GaussianSpans<Real> out;

  template <SetForm form, class Gradient>
  TESSERA_HD void accept(int64_t n, const Gradient& gradient) const {
    Gradient::template for_each_group<form>(gradient, [&](Group group, const Real* g, int width) {
      for (int j = 0; j < width; ++j) out.at(group, n)[j] = g[j];
    });
  }
  /// Scalar j of the SH coefficients: kSh or kShTime.
  TESSERA_HD void accept_sh(Group group, int64_t n, int j, Real gradient) const {
    out.at(group, n)[j] = gradient;
  }
};

template <class Real>
struct ApplyAdam {
  GaussianSpans<Real> value, moment1, moment2;
  AdamGroups<Real> adam;

  template <SetForm form, class Gradient>
  TESSERA_HD void accept(int64_t n, const Gradient& gradient) const {
    Gradient::template for_each_group<form>(gradient, [&](Group group, const Real* g, int width) {
      Real *x = value.at(group, n), *m = moment1.at(group, n), *v = moment2.at(group, n);
      for (int j = 0; j < width; ++j) adam_step(adam.group[group], g[j], x[j], m[j], v[j]);
    });
  }
  TESSERA_HD void accept_sh(Group group, int64_t n, int j, Real gradient) const {
    static_assert(packs_moments(kSh) && packs_moments(kShTime));
    Real *x = value.at(group, n), *m = moment1.at(group, n);
    if constexpr (std::is_same_v<Real, float>)
      adam_step_packed(sh_scalars(group, j), gradient, x[j], m[j]);
    else
      adam_step(sh_scalars(group, j), gradient, x[j], m[j], moment2.at(group, n)[j]);
  }
  /// Step sizes of scalar j.
  TESSERA_HD const AdamScalars<Real>& sh_scalars(Group group, int j) const {
    return group == kSh && j < 3 ? adam.group[kSh] : adam.sh_rest;
  }
};

}  // namespace tessera
