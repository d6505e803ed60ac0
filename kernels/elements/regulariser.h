// What: the gradient of what each Gaussian adds to the loss by its parameters alone; the one place
// for such terms.
// Not: their value; the losses that are reported are those of images.
// Source: method B  [3DGS-MCMC].
#pragma once
#include "kernels/elements/gradient_sink.h"
#include "kernels/elements/load_gaussian.h"

namespace tessera {

/// RegulariserWeights by Gaussian: divided by what their means are over.
template <class Real>
struct RegulariserTerms {
  Real opacity, scale;

  /// `gaussians`: of both sets.
  RegulariserTerms(const RegulariserWeights& weights, int64_t gaussians)
      : opacity(Real(weights.opacity / double(max_of(gaussians, int64_t{1})))),
        scale(Real(weights.scale / (3 * double(max_of(gaussians, int64_t{1}))))) {}
};

/// Adds the terms in stored parameters of Gaussian n, which `share` of the batch's views draw. Of a
/// static Gaussian they are terms of a view's loss, as what the pixels add is: where no view draws
/// it, nothing speaks for it, and Adam would make full steps of however small a gradient. A dynamic
/// Gaussian is drawn near its own time alone, however many cameras there are: it has them in every
/// step. Parameters are read for terms that there are.
// Deviation: [3DGS-MCMC] adds them to every Gaussian in every step; a static one that few of many
// views see then fades between those views.
template <Form form, class Real>
TESSERA_HD inline void add_regulariser(const RegulariserTerms<Real>& terms,
                                       const GaussianSpans<const Real>& set, int64_t n, Real share,
                                       GeometryGradient<Real>& gradient) {
  const Real weight = is_dynamic(form) ? Real(1) : share;
  if (weight == Real(0)) return;
  if (terms.opacity != Real(0)) {
    const Real o = sigmoid(*set.at(kOpacityLogit, n));
    gradient.opacity_logit += weight * terms.opacity * o * (Real(1) - o);
  }
  if (terms.scale != Real(0)) {
    const Vec3<Real> s = load3(set.at(kLogScale, n));
    for (int k = 0; k < 3; ++k) gradient.log_scale[k] += weight * terms.scale * exp(s[k]);
  }
}

}  // namespace tessera
