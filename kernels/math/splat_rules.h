// What: how Gaussians become splats, the same for all views of a batch, in a kernel's precision.
// Not: options (RenderOptions) and no equation.
#pragma once
#include "kernels/math/bounds.h"
#include "kernels/math/filter_2d.h"

namespace tessera {

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
