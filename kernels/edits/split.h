// The children of a split: two samples of the Gaussian they are copies of, or its two halves along
// its longest axis in space. Source: method A.13, D.7; halves: ours.
#pragma once
#include "kernels/load_gaussian.h"
#include "kernels/math/eigen3.h"
#include "kernels/math/four_rotation.h"
#include "kernels/math/random.h"

namespace tessera {

/// A sampled child is smaller by this: ln 1.6  [3DGS].
inline constexpr double kSplitShrink = 0.47000362924573558;

/// Each half lies this many standard deviations from the middle, and is as long, as wide and as
/// opaque as its parent times these. As 0.8² + 0.6² = 1, both together have the parent's variance
/// along the axis.
inline constexpr double kHalfOffset = 0.8, kHalfLength = 0.6, kHalfWidth = 0.9, kHalfOpacity = 0.6;

template <class T>
TESSERA_HD inline int longest_of(const T& lengths) {
  const int of_first_two = lengths[1] > lengths[0] ? 1 : 0;
  return lengths[2] > lengths[of_first_two] ? 2 : of_first_two;
}

/// Moves the copy at element n to a sample of the distribution it is a copy of, and shrinks it.
template <SetForm form, class Real>
TESSERA_HD inline void become_sample(const GaussianSpans<Real>& v, int64_t n, uint64_t seed) {
  const Vec4<float> noise =
      normals(philox(seed, RandomStream::kSplit, uint64_t(n), uint32_t(dim_of(form))));
  Real* s = v.at(kLogScale, n);
  Real* mean = v.at(kMean, n);
  if constexpr (form == SetForm::kPair) {
    const Mat4<Real> R =
        rotation4(load4<Real>(v.at(kRotation, n)), load4<Real>(v.at(kRotationRight, n)));
    Real* s_t = v.at(kLogScaleTime, n);
    const Real along[4] = {Real(noise[0]) * exp(*s_t), Real(noise[1]) * exp(s[0]),
                           Real(noise[2]) * exp(s[1]), Real(noise[3]) * exp(s[2])};
    for (int k = 0; k < 4; ++k) {
      *v.at(kMeanTime, n) += R.m[0][k] * along[k];
      for (int i = 0; i < 3; ++i) mean[i] += R.m[i + 1][k] * along[k];
    }
    *s_t -= Real(kSplitShrink);
  } else {
    const Mat3<Real> R = rotation_matrix(load4<Real>(v.at(kRotation, n)));
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) mean[i] += R[k][i] * Real(noise[k]) * exp(s[k]);
  }
  if constexpr (form == SetForm::kVelocity) {  // the mean moves along with the temporal mean
    const Real* velocity = v.at(kVelocity, n);
    const Real later = Real(noise[3]) * exp(*v.at(kLogScaleTime, n));
    *v.at(kMeanTime, n) += later;
    for (int i = 0; i < 3; ++i) mean[i] += velocity[i] * later;
    *v.at(kLogScaleTime, n) -= Real(kSplitShrink);
  }
  for (int k = 0; k < 3; ++k) s[k] -= Real(kSplitShrink);
}

/// Along the longest axis of Σ_c: Σ_c → S Σ_c S about a mean that keeps its velocity, so that what
/// a pair is in time stays as it is.
template <class Real>
TESSERA_HD inline void become_half_of_pair(const GaussianSpans<Real>& v, int64_t n, Real side) {
  const auto load = [&](Group group) {
    const Real* q = v.at(group, n);
    return Vec4<double>(q[0], q[1], q[2], q[3]);
  };
  Real *s = v.at(kLogScale, n), *s_t = v.at(kLogScaleTime, n), *mean = v.at(kMean, n);
  const Vec4<double> variance = variances4(Vec3<double>(s[0], s[1], s[2]), double(*s_t));
  const Mat4<double> R = rotation4(load(kRotation), load(kRotationRight));
  const Conditional<double> parent = condition_on_time(R, variance);
  Sym3<double> covariance{};
  for (int k = 0; k < 4; ++k) covariance += variance[k] * symmetric_outer(parent.u[k], parent.u[k]);
  const Eigen3 axes = symmetric_eigen(covariance);
  const int longest = longest_of(axes.values);
  const Vec3<double> axis = axes.vectors[longest];
  Mat4<double> axes_of_half;
  for (int k = 0; k < 4; ++k) {
    const double deviation = sqrt(variance[k]), t = R.m[0][k];
    const Vec3<double> along = axis * dot(axis, parent.u[k]);
    const Vec3<double> x = (parent.u[k] - along) * kHalfWidth + along * kHalfLength;
    axes_of_half.m[0][k] = deviation * t;
    for (int i = 0; i < 3; ++i)
      axes_of_half.m[i + 1][k] = deviation * (x[i] + parent.velocity[i] * t);
  }
  const Shape4 half = shape_of(axes_of_half);
  *s_t = Real(log(half.sigma[0]));
  const double distance = kHalfOffset * sqrt(max_of(axes.values[longest], 0.0));
  for (int k = 0; k < 3; ++k) {
    s[k] = Real(log(half.sigma[k + 1]));
    mean[k] += side * Real(distance * axis[k]);
  }
  for (int k = 0; k < 4; ++k) {
    v.at(kRotation, n)[k] = Real(half.left[k]);
    v.at(kRotationRight, n)[k] = Real(half.right[k]);
  }
}

/// Makes of the copy at element n one half of the Gaussian it is a copy of; `side`: ±1.
template <SetForm form, class Real>
TESSERA_HD inline void become_half(const GaussianSpans<Real>& v, int64_t n, Real side) {
  if constexpr (form == SetForm::kPair) {
    become_half_of_pair(v, n, side);
  } else {
    Real *s = v.at(kLogScale, n), *mean = v.at(kMean, n);
    const int longest = longest_of(s);
    const Mat3<Real> R = rotation_matrix(load4<Real>(v.at(kRotation, n)));
    const Real distance = side * Real(kHalfOffset) * exp(s[longest]);
    for (int k = 0; k < 3; ++k) {
      mean[k] += R[longest][k] * distance;
      s[k] += Real(log(k == longest ? kHalfLength : kHalfWidth));
    }
  }
  Real& logit = *v.at(kOpacityLogit, n);
  const Real opacity = Real(kHalfOpacity) * sigmoid(logit);
  logit = log(opacity) - log1p(-opacity);
}

/// Of the copies from `first` on, of which the second half are those of the first half once more.
template <SetForm form, class Real>
TESSERA_HD inline void place_child(const GaussianSpans<Real>& v, int64_t first, int64_t n,
                                   const SplitRule& rule) {
  if (rule.halves)
    become_half<form>(v, n, 2 * (n - first) < v.count - first ? Real(-1) : Real(1));
  else
    become_sample<form>(v, n, rule.seed);
}

}  // namespace tessera
