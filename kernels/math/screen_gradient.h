// What: how strongly the loss pulls a splat across the screen: the statistic by which density
// control grows Gaussians. Not: the threshold (kernels/edits/density.h). Source: [3DGS]; method
// D.6.
#pragma once
#include "kernels/math/symmetric.h"

namespace tessera {

/// ‖dL/d mean2D‖ of one splat in NDC, where the image is 2 wide and high; `d_mean2d` by pixels.
template <class Real>
TESSERA_HD inline Real ndc_gradient_norm(const Vec2<Real>& d_mean2d, int width, int height) {
  const Real x = d_mean2d[0] * Real(width) * Real(0.5);
  const Real y = d_mean2d[1] * Real(height) * Real(0.5);
  return sqrt(x * x + y * y);
}

/// Mean over the `seen` views of a batch of `views` that draw a Gaussian, of whose norms `sum` is
/// the sum. Each is that of the view's own loss, of which the batch's is the mean: times `views`.
template <class Real>
TESSERA_HD inline Real mean_view_norm(Real sum, int views, int seen) {
  return sum * Real(views) / Real(seen);
}

}  // namespace tessera
