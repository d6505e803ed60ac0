// One stored Gaussian in MCMC densification: its opacity while it is alive, its parameters as one
// of several copies, and the random step of its mean along its covariance, which is larger for
// fainter Gaussians. Source: method B  [3DGS-MCMC].
#pragma once
#include "kernels/load_gaussian.h"
#include "kernels/math/random.h"
#include "kernels/math/relocation.h"

namespace tessera {

/// The opacity of Gaussian n, −1 where it is none.
template <SetForm form, class Real>
TESSERA_HD inline double living_opacity(const GaussianSpans<const Real>& set, int64_t n) {
  GaussianState<Real> g;
  return load_gaussian<form>(set, n, g) ? sigmoid(double(*set.at(kOpacityLogit, n))) : -1.0;
}

/// Gaussian n becomes one of `copies`. All axes shrink by f, the one in time too: Σ₄ → f²Σ₄ leaves
/// the velocity b/w as it is, as shrinking three of four axes would not; and the slices before and
/// after μ_t, where 1 − (1 − o'p)^n > o·p, need it as much as the pixels beside the centre do.
template <SetForm form, class Real>
TESSERA_HD inline void become_copies(const GaussianSpans<Real>& set, int64_t n, int copies,
                                     double least_opacity) {
  Real& logit = *set.at(kOpacityLogit, n);
  const Relocated r = relocated(sigmoid(double(logit)), copies);
  const double low = min_of(least_opacity, kMostRelocatedOpacity);
  const double opacity = clamp_to(r.opacity, low, kMostRelocatedOpacity);
  logit = Real(log(opacity) - log1p(-opacity));
  const Real shrink = Real(log(r.scale));
  for (int k = 0; k < 3; ++k) set.at(kLogScale, n)[k] += shrink;
  if constexpr (is_dynamic(form)) *set.at(kLogScaleTime, n) += shrink;
}

/// Gates below this are taken as 0: of opacities above 0.0971.
inline constexpr double kLeastGate = 1e-4;

/// 1 / (1 + exp(100·o − ½)).
template <class Real>
TESSERA_HD inline Real noise_gate(Real opacity) {
  return sigmoid(Real(0.5) - Real(100) * opacity);
}

/// μ += Σ·ξ · scale · gate(o), ξ ~ N(0, I). Σ itself, not its root; of a dynamic Gaussian Σ_c, what
/// views see of it at any time. An invalid Gaussian stays.
template <SetForm form, class Real>
TESSERA_HD inline void add_position_noise(const GaussianSpans<Real>& set, int64_t n,
                                          const PositionNoise& noise) {
  const Real gate = noise_gate(sigmoid(*set.at(kOpacityLogit, n)));
  GaussianState<Real> g;
  if (!(gate >= Real(kLeastGate)) || !load_gaussian<form>(set.view(), n, g)) return;
  const uint64_t index = uint64_t(n) | uint64_t(is_dynamic(form)) << 63;
  const Vec4<float> random =
      normals(philox(noise.seed, RandomStream::kPositionNoise, index, uint32_t(noise.step)));
  const Vec3<Real> step =
      g.spacetime.covariance * Vec3<Real>(Real(random[0]), Real(random[1]), Real(random[2]));
  for (int k = 0; k < 3; ++k) set.at(kMean, n)[k] += Real(noise.scale) * gate * step[k];
}

}  // namespace tessera
