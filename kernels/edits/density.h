// The decision of density control for one Gaussian, and the order in which Gaussians grow where
// room is short. Source: method A.13, D.7; weighted draw: [Efraimidis06].
#pragma once
#include <bit>

#include "kernels/edits/split.h"
#include "kernels/load_gaussian.h"
#include "kernels/math/random.h"

namespace tessera {

/// DensityRule in the units of what is stored.
template <class Real>
struct DensityLimits {
  Real threshold;       // of the statistic
  Real opacity_logit;   // least that is kept
  Real clone, largest;  // log scales
  Real shrink;          // by how much the log scales of children are less at least
  bool drawn;
  uint64_t seed;
};

template <class Real>
DensityLimits<Real> density_limits(const DensityRule& rule) {
  constexpr double kNever = 1e30;
  const auto log_of = [](double size) { return Real(size > 0 ? std::log(size) : -kNever); };
  return {Real(std::min(rule.threshold, kNever)),
          Real(std::log(rule.prune_opacity / (1 - rule.prune_opacity))),
          log_of(rule.largest_clone),
          rule.largest_kept > 0 ? log_of(rule.largest_kept) : Real(kNever),
          Real(rule.halves ? -std::log(kHalfWidth) : kSplitShrink),
          rule.drawn,
          rule.seed};
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

/// Score of Gaussian n if it may grow, else −1.
template <class Real, class T>
TESSERA_HD inline Real candidate_score(const DensityLimits<Real>& limits,
                                       const GaussianSpans<T>& set,
                                       const DensityStatistics<T>& statistics, int64_t n) {
  const Real score = growth_score(statistics.gradient_sum[n], statistics.count[n]);
  return score >= limits.threshold && is_alive(limits, set, n) ? score : Real(-1);
}

/// Candidates grow in ascending order of their keys: the strongest first, or a draw without
/// replacement in proportion to their scores, which is the order of −ln(U)/score.
template <class Real>
TESSERA_HD inline uint32_t growth_key(const DensityLimits<Real>& limits, Real score, int64_t n) {
  if (!limits.drawn) return ~std::bit_cast<uint32_t>(float(score));
  const RandomBlock block = philox(limits.seed, RandomStream::kGrowth, uint64_t(n));
  const float wait = -log(1.0f - uniform(block.word[0]));
  return std::bit_cast<uint32_t>(wait / max_of(float(score), 1e-30f));
}

/// What becomes of a Gaussian that is alive. `grows`: its score is high enough and there is room.
template <class Real, class T>
TESSERA_HD inline Fate fate_of(const DensityLimits<Real>& limits, const GaussianSpans<T>& set,
                               int64_t n, bool grows) {
  const Real* s = set.at(kLogScale, n);
  const Real scale = max_of(max_of(s[0], s[1]), s[2]);
  if (grows && scale > limits.clone)  // children are removed by the same rule as everyone else
    return scale - limits.shrink > limits.largest ? Fate::kRemoved : Fate::kSplit;
  if (scale > limits.largest) return Fate::kRemoved;
  return grows ? Fate::kCloned : Fate::kKept;
}

}  // namespace tessera
