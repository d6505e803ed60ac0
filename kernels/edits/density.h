// The decision of density control for one Gaussian, and the places of the children of a split.
// Source: method A.13, D.7.
#pragma once
#include "kernels/load_gaussian.h"
#include "kernels/math/random.h"

namespace tessera {

/// Children of a split are smaller by this: ln 1.6  [3DGS].
inline constexpr double kSplitShrink = 0.47000362924573558;

/// DensityRule in the units of what is stored.
template <class Real>
struct DensityLimits {
  Real threshold;       // of the statistic
  Real opacity_logit;   // least that is kept
  Real clone, largest;  // log scales
};

template <class Real>
DensityLimits<Real> density_limits(const DensityRule& rule) {
  constexpr double kNever = 1e30;
  const auto log_of = [](double size) { return Real(size > 0 ? std::log(size) : -kNever); };
  return {Real(std::min(rule.threshold, kNever)),
          Real(std::log(rule.prune_opacity / (1 - rule.prune_opacity))), log_of(rule.largest_clone),
          rule.largest_kept > 0 ? log_of(rule.largest_kept) : Real(kNever)};
}

enum class Fate : uint8_t { kRemoved, kKept, kCloned, kSplit };

/// Opaque enough, and a Gaussian at all.
template <class Real, class T>
TESSERA_HD inline bool is_alive(const DensityLimits<Real>& limits, const GaussianSpans<T>& set,
                                int64_t n) {
  const Vec4<Real> q = load4<Real>(set.at(kRotation, n));
  if (!(dot(q, q) >= kMinQuaternionNorm2<Real>)) return false;
  if (set.form == SetForm::kPair) {
    const Vec4<Real> r = load4<Real>(set.at(kRotationRight, n));
    if (!(dot(r, r) >= kMinQuaternionNorm2<Real>)) return false;
  }
  return *set.at(kOpacityLogit, n) >= limits.opacity_logit;
}

/// Mean gradient of the batches that saw it; −1 where none did.
template <class Real>
TESSERA_HD inline Real growth_score(Real gradient_sum, Real count) {
  return count > Real(0) ? gradient_sum / count : Real(-1);
}

/// What becomes of a Gaussian that is alive. `grows`: its score is high enough and there is room.
template <class Real, class T>
TESSERA_HD inline Fate fate_of(const DensityLimits<Real>& limits, const GaussianSpans<T>& set,
                               int64_t n, bool grows) {
  const Real* s = set.at(kLogScale, n);
  const Real scale = max_of(max_of(s[0], s[1]), s[2]);
  if (grows && scale > limits.clone)  // children are removed by the same rule as everyone else
    return scale - Real(kSplitShrink) > limits.largest ? Fate::kRemoved : Fate::kSplit;
  if (scale > limits.largest) return Fate::kRemoved;
  return grows ? Fate::kCloned : Fate::kKept;
}

/// Moves the copy at element n to a sample of the distribution it is a copy of, and shrinks it.
template <SetForm form, class Real>
TESSERA_HD inline void place_child(const GaussianSpans<Real>& v, int64_t n, uint64_t seed) {
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

}  // namespace tessera
