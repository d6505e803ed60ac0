// What: the gradient of what each Gaussian adds to the loss by its parameters alone; the one place
// for such terms.
// Not: their value; the losses that are reported are those of images.
// Source: method B  [3DGS-MCMC]; motion, rigidity: method D.8  [Yang24]; extent: ours.
#pragma once
#include <cmath>

#include "kernels/elements/load_gaussian.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {

/// RegulariserWeights by Gaussian: divided by what their means are over; and who moves with whom.
template <class Real>
struct RegulariserTerms {
  Real opacity, scale, motion, extent, rigidity, slow;
  MotionPairs<Real> pairs;
  Span<const Real> velocities;  // [N, 3] of the dynamic set, where there are pairs

  /// `fixed`, `moving`: Gaussians of the two sets. `v`: see store_velocity.
  RegulariserTerms(const RegulariserWeights& weights, const MotionPairs<Real>& together,
                   Span<const Real> v, int64_t fixed, int64_t moving)
      : opacity(Real(weights.opacity / double(max_of(fixed + moving, int64_t{1})))),
        scale(Real(weights.scale / (3 * double(max_of(fixed + moving, int64_t{1}))))),
        motion(Real(weights.motion / double(max_of(moving, int64_t{1})))),
        extent(Real(weights.extent / double(max_of(moving, int64_t{1})))),
        rigidity(Real(together.first.empty() ? 0 : weights.rigidity)),
        slow(Real(weights.slow)),
        pairs(together),
        velocities(v) {}

  /// Whether there are terms in what Spacetime holds, of a set in that form.
  template <Form form>
  TESSERA_HD bool in_spacetime() const {
    return form != Form::kStatic && (motion != Real(0) || extent != Real(0) || rigidity != Real(0));
  }
};

/// v of Gaussian n as it is drawn; not a number where there is none.
template <Form form, class Real>
TESSERA_HD inline void store_velocity(const GaussianSpans<const Real>& set, int64_t n,
                                      Real* velocities) {
  GaussianState<Real> g;
  const bool sound = load_gaussian<form>(set, n, g);
  for (int k = 0; k < 3; ++k) velocities[3 * n + k] = sound ? g.spacetime.velocity[k] : Real(NAN);
}

/// Gradient of the pairs of Gaussian n by its velocity, but for the weight.
template <class Real>
TESSERA_HD inline Vec3<Real> pairs_backward(const RegulariserTerms<Real>& terms, int64_t n) {
  Vec3<Real> sum(Real(0));
  const Vec3<Real> v = load3(terms.velocities.data + 3 * n);
  for (int64_t k = terms.pairs.first[n]; k < terms.pairs.first[n + 1]; ++k) {
    const Vec3<Real> apart = v - load3(terms.velocities.data + 3 * terms.pairs.other[k]);
    const Real squared = dot(apart, apart);
    if (squared - squared == Real(0))  // both are Gaussians
      sum += (terms.pairs.affinity[k] / sqrt(squared + terms.slow * terms.slow)) * apart;
  }
  return sum;
}

/// Adds the terms in v and 1/σ_t² of dynamic Gaussian n to the sums over its views;
/// geometry_gradient leads them to what its form stores. `extent` pulls ln σ_t up with the same
/// force however short the life, and not at all from one clip length on.
template <class Real>
TESSERA_HD inline void add_spacetime_regulariser(const RegulariserTerms<Real>& terms, int64_t n,
                                                 const Spacetime<Real>& s,
                                                 SpacetimeGradient<Real>& d) {
  if (terms.motion != Real(0)) {
    const Real speed = sqrt(dot(s.velocity, s.velocity) + terms.slow * terms.slow);
    d.velocity += (terms.motion / speed) * s.velocity;
  }
  if (terms.extent != Real(0) && s.precision_time > Real(1))
    d.precision_time += Real(0.5) * terms.extent / s.precision_time;
  if (terms.rigidity != Real(0)) d.velocity += terms.rigidity * pairs_backward(terms, n);
}

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
  const Real weight = form == Form::kStatic ? share : Real(1);
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
