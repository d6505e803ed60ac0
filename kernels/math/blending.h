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

/// A pixel's step past a splat of that α (0: it is not drawn): its colour gains T·α·c, and T is
/// what is left behind the splat afterwards.
template <class Real>
TESSERA_HD inline void blend_step(Real alpha, const Vec3<Real>& colour, Real& red, Real& green,
                                  Real& blue, Real& transmittance) {
  const Real weight = transmittance * alpha;
  red += weight * colour[0];
  green += weight * colour[1];
  blue += weight * colour[2];
  transmittance *= Real(1) - alpha;
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
    conic.xx += o.conic.xx;
    conic.xy += o.conic.xy;
    conic.yy += o.conic.yy;
    opacity += o.opacity;
    colour += o.colour;
    return *this;
  }
};

/// How a splat meets a pixel.
template <class Real>
struct SplatAtPixel {
  Real dx, dy;   // mean2d − pixel centre
  Real gx, gy;   // conic · (dx, dy), or a multiple of it
  Real falloff;  // G
  Real alpha;    // o·p·G
};

inline constexpr int kSplatGradientTerms = 9;  // scalars of a SplatGradient

/// A pixel's step past a splat, backward: calls add(k, term) with its share of the k-th scalar of
/// the splat's gradient, in the order of SplatGradient. `drawn`: whether the splat is drawn there;
/// `g`: dL/dC; `remaining`: R = ⟨colour still to come, g⟩, in front of the splat before and behind
/// it afterwards, as T is  [method A.11]. The share of the conic is twice its gradient, and that of
/// mean2d by gx and gy as they are given.
template <class Real, class Add>
TESSERA_HD inline void blend_backward_step(const SplatAtPixel<Real>& splat, bool drawn,
                                           const Vec3<Real>& colour, const Vec3<Real>& g,
                                           Real& transmittance, Real& remaining, Add&& add) {
  const Real alpha = drawn ? splat.alpha : Real(0);
  const Real weight = transmittance * alpha;
  const Real kappa = colour[0] * g[0] + colour[1] * g[1] + colour[2] * g[2];
  remaining -= weight * kappa;
  // by the α of any splat: where none is drawn the quotient is not used, and loops stay vectors
  const Real rest = max_of(Real(1) - splat.alpha, kMinOneMinusAlpha<Real>);
  const Real beyond = fast_divide(remaining, rest);
  const Real d_alpha = drawn ? transmittance * kappa - beyond : Real(0);
  const Real h = -alpha * d_alpha;
  const Real hx = h * splat.dx;
  const Real hy = h * splat.dy;
  add(0, h * splat.gx);
  add(1, h * splat.gy);
  add(2, hx * splat.dx);
  add(3, hx * splat.dy);
  add(4, hy * splat.dy);
  add(5, splat.falloff * d_alpha);
  add(6, weight * g[0]);
  add(7, weight * g[1]);
  add(8, weight * g[2]);
  transmittance *= Real(1) - alpha;
}

}  // namespace tessera
