// What: the gradient of what each Gaussian adds to the loss by its parameters alone; the one place
// for such terms.
// Not: their value; the losses that are reported are those of pictures.
// Source: method B  [3DGS-MCMC].
#pragma once
#include "kernels/math/splat.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {

/// RegulariserWeights by Gaussian: divided by what their means are over.
template <class Real>
struct RegulariserTerms {
  Real opacity, scale;

  /// `count`: Gaussians of both sets.
  RegulariserTerms(const RegulariserWeights& weights, int64_t count)
      : opacity(Real(weights.opacity / double(count < 1 ? 1 : count))),
        scale(Real(weights.scale / (3 * double(count < 1 ? 1 : count)))) {}
};

/// Adds the terms of Gaussian n. Parameters are read for terms that there are.
template <Form form, class Real>
TESSERA_HD inline void add_regulariser(const RegulariserTerms<Real>& terms,
                                       const GaussianSpans<const Real>& set, int64_t n,
                                       GeometryGradient<Real>& gradient) {
  if (terms.opacity != Real(0)) {
    const Real o = sigmoid(*set.at(kOpacityLogit, n));
    gradient.opacity_logit += terms.opacity * o * (Real(1) - o);
  }
  if (terms.scale != Real(0)) {
    const Vec3<Real> s = load3(set.at(kLogScale, n));
    for (int k = 0; k < 3; ++k) gradient.log_scale[k] += terms.scale * exp(s[k]);
  }
}

}  // namespace tessera
