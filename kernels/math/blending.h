// What: one splat over one pixel, front to back: forward step and backward step.
// Not: loops over pixels or splats; those are the backends'.
// Source: [3DGS]; scalar-R backward: method A.11.
#pragma once
#include "kernels/math/bounds.h"

namespace tessera {

/// A pixel is finished when less than this of the light behind it remains  [3DGS].
template <class Real>
inline constexpr Real kMinTransmittance = Real(1e-4);
/// Guards the division by 1 − α  [method A.11]. Deviation: α is not clamped to 0.99 as in [3DGS].
template <class Real>
inline constexpr Real kMinOneMinusAlpha = Real(1e-6);

/// G = exp(min(−½ dᵀ conic d, 0)) at offset (dx, dy) = mean2d − pixel centre.
template <class Real>
TESSERA_HD inline Real splat_falloff(const Sym2<Real>& conic, Real dx, Real dy) {
  const Real e = Real(-0.5) * (conic.xx * dx * dx + conic.yy * dy * dy) - conic.xy * dx * dy;
  return fast_exp(min_of(e, Real(0)));
}

/// Gradient of one splat, summed over pixels.
template <class Real>
struct SplatGradient {
  Vec2<Real> mean2d;  // by pixels
  Sym2<Real> conic;   // symmetric convention
  Real opacity;       // by the effective opacity o·p
  Vec3<Real> colour;  // by the un-clamped colour, before the mask of negative channels

  TESSERA_HD SplatGradient& operator+=(const SplatGradient& o) {
    mean2d += o.mean2d;
    conic.xx += o.conic.xx, conic.xy += o.conic.xy, conic.yy += o.conic.yy;
    opacity += o.opacity, colour += o.colour;
    return *this;
  }
};

}  // namespace tessera
