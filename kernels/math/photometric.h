// What: (1−λ)·L1 + λ·(1 − SSIM) of a view from its sums, and its gradient at one sample.
// Not: SSIM itself (ssim.h), nor the convolution of its partials (the photometric stage).
// Source: [3DGS]; method A.15.
#pragma once
#include <cstdint>

#include "kernels/math/scalar.h"

namespace tessera {

struct LossWeights {
  double l1 = 0.8;     // weight of mean |I − G|
  double dssim = 0.2;  // weight of 1 − SSIM
  double moving = 1;   // of |I − G| where the mask is kMovingPixel
};

/// Value of a mask where something moves: these pixels may weigh more than others.
constexpr uint8_t kMovingPixel = 2;

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
