// One splat over one pixel, front to back: the forward step and the backward step of blending.
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
  transmittance -= weight;
}

/// Gradient of the loss by one splat.
template <class Real>
struct SplatGradient {
  Vec2<Real> mean2d;  // by pixels
  Sym2<Real> conic;   // symmetric convention
  Real opacity;       // by the effective opacity o·p
  Vec3<Real> colour;  // by the un-clamped colour, before the mask of negative channels
};

/// Sums over a splat's pixels that its gradient follows from: of f = G·dL/dα, of its moments by
/// d = mean2d − pixel centre, and of T·α·dL/dC.
template <class Real>
struct SplatMoments {
  Real f;
  Vec2<Real> f_d;
  Sym2<Real> f_dd;
  Vec3<Real> colour;

  TESSERA_HD SplatMoments& operator+=(const SplatMoments& o) {
    f += o.f;
    f_d += o.f_d;
    f_dd += o.f_dd;
    colour += o.colour;
    return *this;
  }
};
/// And Σ over pixels of |f|·‖conic·d‖.
template <class Real>
struct MomentsAndLength : SplatMoments<Real> {
  Real length;

  TESSERA_HD MomentsAndLength& operator+=(const MomentsAndLength& o) {
    SplatMoments<Real>::operator+=(o);
    length += o.length;
    return *this;
  }
};
inline constexpr int kSplatMomentTerms = 9;  // scalars of a SplatMoments

/// ‖conic·d‖: a pixel's gradient by the place of its splat is −o·f·conic·d.
template <class Real>
TESSERA_HD inline Real slope_length(const Sym2<Real>& conic, Real dx, Real dy) {
  const Real x = conic.xx * dx + conic.xy * dy, y = conic.xy * dx + conic.yy * dy;
  return sqrt(x * x + y * y);
}

/// By α = o·G, G = exp(−½ dᵀ conic d).
template <class Real>
TESSERA_HD inline SplatGradient<Real> splat_gradient(const Sym2<Real>& conic, Real opacity,
                                                     const SplatMoments<Real>& m) {
  const Real half = Real(-0.5) * opacity;
  return {Vec2<Real>(conic.xx * m.f_d[0] + conic.xy * m.f_d[1],
                     conic.xy * m.f_d[0] + conic.yy * m.f_d[1]) *
              -opacity,
          {half * m.f_dd.xx, half * m.f_dd.xy, half * m.f_dd.yy},
          m.f,
          m.colour};
}

inline constexpr int kColumnTerms = 6;  // sums over the pixels of a column

/// A pixel's step past a splat, backward: calls add(k, term) with its share of the k-th sum of its
/// column. `opacity`: o·p of the splat; `falloff`: its G there, 0 where it is not drawn; `dy`: of
/// d; `g`: dL/dC; `remaining`: R = ⟨colour still to come, g⟩, in front of the splat before and
/// behind it afterwards, as T is  [method A.11].
template <class Real, class Add>
TESSERA_HD inline void blend_backward_step(Real opacity, Real falloff, Real dy,
                                           const Vec3<Real>& colour, const Vec3<Real>& g,
                                           Real& transmittance, Real& remaining, Add&& add) {
  const Real alpha = opacity * falloff;
  const Real weight = transmittance * alpha;
  const Real kappa = colour[0] * g[0] + colour[1] * g[1] + colour[2] * g[2];
  remaining -= weight * kappa;
  const Real rest = max_of(Real(1) - alpha, kMinOneMinusAlpha<Real>);
  const Real d_alpha = transmittance * kappa - fast_divide(remaining, rest);
  const Real f = falloff * d_alpha;
  const Real f_dy = f * dy;
  add(0, f);
  add(1, f_dy);
  add(2, f_dy * dy);
  add(3, weight * g[0]);
  add(4, weight * g[1]);
  add(5, weight * g[2]);
  transmittance -= weight;
}

/// Of a column of pixels, which share dx, from its sums.
template <class Real>
TESSERA_HD inline SplatMoments<Real> column_moments(Real dx, const Real (&sum)[kColumnTerms]) {
  const Real f_dx = sum[0] * dx;
  return {sum[0],
          Vec2<Real>(f_dx, sum[1]),
          {f_dx * dx, sum[1] * dx, sum[2]},
          Vec3<Real>(sum[3], sum[4], sum[5])};
}

}  // namespace tessera
