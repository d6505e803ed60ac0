// What: how Gaussians become splats, the same for all views of a batch, in a kernel's precision.
// Not: options (RenderOptions) and no equation.
#pragma once
#include "kernels/math/bounds.h"
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

template <class Real>
struct SplatRules {
  Real near_plane, far_plane;  // world units
  Real dilation;               // κ, pixels²
  Real time_filter;            // f, normalised time²: added to σ_t² in the marginal
  bool compensated;            // 2D filter: opacities are multiplied by comp
  Cutoff<Real> cutoff;
  BoundsOptions bounds;
};

}  // namespace tessera
