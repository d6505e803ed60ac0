// What: one stored Gaussian in MCMC: whether it lives, and what it becomes as one of several
// copies. Not: the formulas of copies (kernels/math/relocation.h). Source: method B  [3DGS-MCMC].
#pragma once
#include "kernels/elements/load_gaussian.h"
#include "kernels/math/relocation.h"

namespace tessera {

/// The opacity of Gaussian n, −1 where it is none.
template <Form form, class Real>
TESSERA_HD inline double living_opacity(const GaussianSpans<const Real>& set, int64_t n) {
  GaussianState<Real> g;
  return load_gaussian<form>(set, n, g) ? sigmoid(double(*set.at(kOpacityLogit, n))) : -1.0;
}

/// Gaussian n becomes one of `copies`. All axes shrink by f, the one in time too: Σ₄ → f²Σ₄ leaves
/// the velocity b/w as it is, as shrinking three of four axes would not; and the slices before and
/// after μ_t, where 1 − (1 − o'p)^n > o·p, need it as much as the pixels beside the centre do.
template <Form form, class Real>
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

}  // namespace tessera
