// What: the 2D Mip filter: a splat is dilated by κ and dimmed so that it keeps its light.
// Not: the dilation itself (ewa.h), nor where the opacity is used (splat.h).
// Source: [Mip-Splatting]; method C.2.
#pragma once
#include "kernels/math/symmetric.h"

namespace tessera {

/// κ with the filter: the variance of a pixel, pixels²  [Mip-Splatting].
template <class Real>
inline constexpr Real kFilter2d = Real(0.1);

/// comp = √max(0, det(Σ2 − κI)/det Σ2), Σ2 with its dilation. The quotient is det(I − κ·conic).
template <class Real>
TESSERA_HD inline Real compensation(const Sym2<Real>& conic, Real dilation) {
  const Real x = Real(1) - dilation * conic.xx, y = Real(1) - dilation * conic.yy;
  const Real xy = dilation * conic.xy;
  return sqrt(max_of(Real(0), x * y - xy * xy));
}

}  // namespace tessera
