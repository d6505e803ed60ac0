// Conversion of one stored Gaussian of a set to the values that a view needs; the values of a
// canonical Gaussian are those that motion nodes give it in that view. Source: method A.5, A.6,
// C.1, D.9.
#pragma once
#include "kernels/gaussians.h"
#include "kernels/math/splat.h"

namespace tessera {

template <class Real>
TESSERA_HD inline Vec3<Real> load3(const Real* p) {
  return Vec3<Real>(p[0], p[1], p[2]);
}
template <class Real>
TESSERA_HD inline Vec4<Real> load4(const Real* p) {
  return Vec4<Real>(p[0], p[1], p[2], p[3]);
}

/// False for a Gaussian that is no Gaussian: a quaternion of no length, a value not finite.
template <SetForm form, class Real>
TESSERA_HD inline bool load_gaussian(const GaussianSpans<const Real>& set, int64_t n,
                                     GaussianState<Real>& g) {
  const Vec4<Real> q = load4(set.at(kRotation, n));
  Vec3<Real> log_scale = load3(set.at(kLogScale, n));
  if (!(dot(q, q) >= kMinQuaternionNorm2<Real>)) return false;
  g.stored_opacity = g.opacity = sigmoid(*set.at(kOpacityLogit, n));
  if (!set.filter_size.empty()) {
    const Smoothed<Real> smoothed = smooth(log_scale, Real(set.filter_size[n]));
    log_scale = smoothed.log_scale;
    g.opacity *= smoothed.compensation;
  }
  g.log_scale = log_scale;
  if constexpr (form == SetForm::kPair) {
    const Vec4<Real> r = load4(set.at(kRotationRight, n));
    if (!(dot(r, r) >= kMinQuaternionNorm2<Real>)) return false;
    g.spacetime = pair_spacetime(q, r, log_scale, *set.at(kLogScaleTime, n), *set.at(kMeanTime, n));
  } else if constexpr (form == SetForm::kVelocity) {
    g.spacetime = velocity_spacetime(q, log_scale, load3(set.at(kVelocity, n)),
                                     *set.at(kLogScaleTime, n), *set.at(kMeanTime, n));
  } else {
    g.spacetime = static_spacetime(q, log_scale);
  }
  g.mean = load3(set.at(kMean, n));
  // of a set whose elements differ in K these lead nowhere: who needs colours has a block of it
  g.sh = set.group[kSh].data + n * set.width(kSh);
  g.sh_time = set.group[kShTime].data + n * set.width(kShTime);
  const Sym3<Real>& c = g.spacetime.covariance;
  const Real trace = c.xx + c.yy + c.zz;
  Real stored = g.mean[0] + g.mean[1] + g.mean[2] + *set.at(kOpacityLogit, n) + log_scale[0] +
                log_scale[1] + log_scale[2];
  if constexpr (is_dynamic(form)) stored += *set.at(kLogScaleTime, n);
  if constexpr (form == SetForm::kVelocity) {
    const Vec3<Real> v = g.spacetime.velocity;
    stored += v[0] + v[1] + v[2];
  }
  const Real sum = stored + trace + g.spacetime.mean_time + g.spacetime.precision_time;
  return sum - sum == Real(0);  // finite
}

/// Gaussian n, loaded as `at_rest`, as view b of the batch sees it: of a canonical set in `room`,
/// where its mean and its covariance are those that it is carried to; of others `at_rest` itself.
template <SetForm form, class Real>
TESSERA_HD inline const GaussianState<Real>& state_in_view(const GaussianSpans<const Real>& set,
                                                           int64_t n, int b,
                                                           const GaussianState<Real>& at_rest,
                                                           GaussianState<Real>& room) {
  if constexpr (form == SetForm::kCanonical) {
    const CarriedGaussian<Real>& carried = set.carried[b * set.carried_stride + n];
    room = at_rest;
    room.mean = carried.mean;
    room.spacetime = static_spacetime(carried.rotation, at_rest.log_scale);
    return room;
  } else {
    return at_rest;
  }
}

}  // namespace tessera
