// Conversion of one dynamic Gaussian to a static one.
#pragma once
#include "kernels/load_gaussian.h"
#include "kernels/math/eigen3.h"
#include "kernels/math/spherindrical.h"

namespace tessera {

/// Element n of `from` into `to`, a static set: where it is at `timestep`, with the shape and
/// colours of its slice there, and with the opacity `opacity`. One without opacity or that is no
/// Gaussian is where its own mean timestep has it, as stored.
template <SetForm form, class Real>
TESSERA_HD inline void store_demoted(const GaussianSpans<const Real>& from,
                                     const ColourRules<Real>& colours, int64_t n, Real timestep,
                                     Real opacity, const GaussianSpans<Real>& to) {
  for (const Group group : {kMean, kLogScale, kRotation, kOpacityLogit, kSh})
    for (int k = 0; k < from.width(group); ++k) to.at(group, n)[k] = from.at(group, n)[k];
  GaussianState<Real> g;
  if (!(opacity > Real(0)) || !load_gaussian<form>(from, n, g)) return;
  const Slice<Real> slice = slice_at(g.mean, g.spacetime, timestep);
  Real room[3 * kMaxShCoefficients];
  const Real* const sh = sh_at(colours, g, slice.delta, room);
  for (int k = 0; k < colours.scalars(); ++k) to.at(kSh, n)[k] = sh[k];
  const Sym3<Real>& c = g.spacetime.covariance;
  const Shape3 shape = shape_of(Sym3<double>{c.xx, c.xy, c.xz, c.yy, c.yz, c.zz});
  for (int k = 0; k < 3; ++k) {
    to.at(kMean, n)[k] = slice.mean[k];
    to.at(kLogScale, n)[k] = Real(shape.log_scale[k]);
  }
  for (int k = 0; k < 4; ++k) to.at(kRotation, n)[k] = Real(shape.rotation[k]);
  const double p = min_of(max_of(double(opacity), 1e-4), 1 - 1e-6);
  *to.at(kOpacityLogit, n) = Real(log(p / (1 - p)));
}

}  // namespace tessera
