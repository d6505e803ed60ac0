// What: the random step of one Gaussian's mean, along its own covariance, the larger the fainter.
// Not: its size over the training (recon4d/training/schedule.h).
// Source: method B  [3DGS-MCMC].
#pragma once
#include "kernels/elements/load_gaussian.h"
#include "kernels/math/random.h"

namespace tessera {

/// Gates below this are taken as 0: of opacities above 0.0971.
inline constexpr double kLeastGate = 1e-4;

/// 1 / (1 + exp(100·o − ½)).
template <class Real>
TESSERA_HD inline Real noise_gate(Real opacity) {
  return sigmoid(Real(0.5) - Real(100) * opacity);
}

/// μ += Σ·ξ · scale · gate(o), ξ ~ N(0, I). Σ itself, not its root; of a dynamic Gaussian Σ_c, what
/// views see of it at any moment. What is no Gaussian stays.
template <Form form, class Real>
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
