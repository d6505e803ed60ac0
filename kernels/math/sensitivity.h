// The sensitivity of images to one splat: its blending weight, the colour that it covers, and the
// squared error without it, as the step of one pixel past one splat. Source: blending without one
// term; Q is the colour of which method A.11 keeps R = ⟨Q, g⟩ alone.
#pragma once
#include "kernels/math/blending.h"

namespace tessera {

/// Sums over a splat's pixels p and channels c; w = T·α, x: the image that is measured, e:
/// how it follows the colour (its gain; 0 where a mask ignores the pixel), m: whether the pixel may
/// move (1 or 0), ΔC: how the blended colour changes where the splat is not there. With x the
/// residual, removal1 + removal2 is the change of Σ x² when that splat alone is taken out; exact
/// but for pixels whose blending stopped at kMinTransmittance, where the background stands for what
/// was never drawn.
template <class Real>
struct SplatSensitivity {
  Real weight;       // Σ w
  Real weight2;      // Σ w²
  Vec3<Real> image;  // Σ w·x_c
  Real removal1;     // Σ 2·x_c·e_c·ΔC_c
  Real removal2;     // Σ (e_c·ΔC_c)²
  Real moving;       // Σ w·m

  TESSERA_HD SplatSensitivity& operator+=(const SplatSensitivity& o) {
    weight += o.weight;
    weight2 += o.weight2;
    image += o.image;
    removal1 += o.removal1;
    removal2 += o.removal2;
    moving += o.moving;
    return *this;
  }
};

/// ΔC = (Q − w·c)/(1 − α) − Q = α·((Q − w·c)/(1 − α) − T·c) of one channel. `to_come`: Q, the
/// colour still to come in front of the splat, background included; behind it afterwards.
template <class Real>
TESSERA_HD inline Real removal_change(Real alpha, Real inverse_rest, Real transmittance,
                                      Real colour, Real& to_come) {
  const Real light = transmittance * colour;
  to_come -= alpha * light;
  return alpha * (to_come * inverse_rest - light);
}

/// A pixel takes its step past a splat of that α (0: it does not draw the pixel) and says what the
/// pixel adds to the splat's sums; x, e and m as above. `transmittance` and `to_come` are those
/// behind the splat afterwards.
template <class Real>
TESSERA_HD inline SplatSensitivity<Real> sensitivity_step(Real alpha, const Vec3<Real>& colour,
                                                          const Vec3<Real>& x, const Vec3<Real>& e,
                                                          Real m, Real& transmittance,
                                                          Vec3<Real>& to_come) {
  const Real rest = Real(1) - alpha;
  const Real inverse = fast_divide(Real(1), max_of(rest, kMinOneMinusAlpha<Real>));
  const Real T = transmittance;
  const Real d0 = e.x * removal_change(alpha, inverse, T, colour.x, to_come.x);
  const Real d1 = e.y * removal_change(alpha, inverse, T, colour.y, to_come.y);
  const Real d2 = e.z * removal_change(alpha, inverse, T, colour.z, to_come.z);
  const Real weight = T * alpha;
  transmittance -= weight;
  return {weight,
          weight * weight,
          Vec3<Real>(weight * x.x, weight * x.y, weight * x.z),
          Real(2) * (x.x * d0 + x.y * d1 + x.z * d2),
          d0 * d0 + d1 * d1 + d2 * d2,
          weight * m};
}

}  // namespace tessera
