// SSIM of one window from its moments with its partial derivatives, the loss (1−λ)·L1 + λ·(1 −
// SSIM) of a view from its sums, and its gradient at one sample. Source: [Wang04], [3DGS]; method
// A.15.
#pragma once
#include <cstdint>

#include "kernels/math/scalar.h"

namespace tessera {

inline constexpr int kSsimRadius = 5;
inline constexpr int kSsimTaps = 2 * kSsimRadius + 1;
template <class Real>
inline constexpr Real kSsimC1 = Real(1e-4);  // (0.01·range)²
template <class Real>
inline constexpr Real kSsimC2 = Real(9e-4);  // (0.03·range)²

/// Normalised Gaussian taps, σ = 1.5 pixels.
template <class Real>
inline constexpr Real kSsimWindow[kSsimTaps] = {
    Real(0.00102838008447911), Real(0.00759875813523919), Real(0.03600077212843083),
    Real(0.10936068950970002), Real(0.21300553771125369), Real(0.26601172486179436),
    Real(0.21300553771125369), Real(0.10936068950970002), Real(0.03600077212843083),
    Real(0.00759875813523919), Real(0.00102838008447911)};

/// Windowed means of x, y, x² + y², x·y: SSIM has the two variances only as their sum.
template <class Real>
struct SsimMoments {
  Real x, y, squares, xy;
};

/// SSIM is C·D / (A·B): luminance C/A, contrast and structure D/B.
template <class Real>
struct SsimTerms {
  Real A, B, C, D;
};

template <class Real>
TESSERA_HD inline SsimTerms<Real> ssim_terms(const SsimMoments<Real>& m, Real c1 = kSsimC1<Real>,
                                             Real c2 = kSsimC2<Real>) {
  const Real means = m.x * m.x + m.y * m.y;
  const Real variances = max_of(Real(0), m.squares - means);
  return {means + c1, variances + c2, Real(2) * m.x * m.y + c1, Real(2) * (m.xy - m.x * m.y) + c2};
}

/// SSIM and its partials by E[x], E[x²], E[x·y] with the other moments fixed.
template <class Real>
struct SsimPoint {
  Real value, d_x, d_xx, d_xy;
};

template <class Real>
TESSERA_HD inline SsimPoint<Real> ssim_point(const SsimMoments<Real>& m, Real c2 = kSsimC2<Real>) {
  const auto [A, B, C, D] = ssim_terms(m, kSsimC1<Real>, c2);
  const Real inverse = fast_divide(Real(1), A * B);
  const Real S = C * D * inverse;
  SsimPoint<Real> p;
  p.value = S;
  p.d_x = Real(2) * inverse * (m.y * (D - C) + m.x * S * (A - B));
  p.d_xx = fast_divide(-S, B);
  p.d_xy = Real(2) * C * inverse;
  return p;
}

struct LossWeights {
  double l1 = 0.8;     // weight of mean |I − G|
  double dssim = 0.2;  // weight of 1 − SSIM
  double moving = 1;   // of |I − G| where the mask is kMovingPixel
  double noise = 0;    // standard deviation of the noise of G, [0, 1]

  /// C₂ of SSIM + 2σ²: the contrast of noise alone, in both images, counts as equal.
  /// Deviation: [Wang04] has C₂ alone, by which a loss rewards what fits the noise (noise 0).
  double c2() const { return kSsimC2<double> + 2 * noise * noise; }
};

/// Values of a mask, of which 0 ignores a pixel. Where something moves, pixels may weigh more than
/// others; kUnknownPixel, as any larger value: it counts, and nothing tells whether it moves.
constexpr uint8_t kStillPixel = 1, kMovingPixel = 2, kUnknownPixel = 3;
TESSERA_HD inline bool may_move(uint8_t mask) {
  return mask >= kMovingPixel;
}

/// Loss of one view, un-divided by B.
struct ViewLoss {
  double l1 = 0, ssim = 0, total = 0;
};

/// `l1`, `ssim`: sums of |x − y| and of SSIM over the `samples` of a view.
inline ViewLoss view_loss(const LossWeights& weights, double l1, double ssim, double samples) {
  const double mean_l1 = l1 / samples;
  const double mean_ssim = ssim / samples;
  return {mean_l1, mean_ssim, weights.l1 * mean_l1 + weights.dssim * (1 - mean_ssim)};
}

/// dL/dx = w·sign(x − y) + P + 2x·Q + y·U of one sample, for the convolved partials of the SSIM
/// term by E[x], E[x²] and E[x·y].
template <class Real>
TESSERA_HD inline Real photometric_gradient(Real l1_weight, Real x, Real y, Real by_x, Real by_xx,
                                            Real by_xy) {
  const Real sign = x > y ? Real(1) : (x < y ? Real(-1) : Real(0));
  return l1_weight * sign + by_x + Real(2) * x * by_xx + y * by_xy;
}

}  // namespace tessera
