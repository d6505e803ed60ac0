// Colour from real spherical harmonics to degree 3, and the gradient by coefficients and direction.
// Coefficients are [K, 3] with RGB innermost. Source: [3DGS] storage order and signs; unit-norm
// polynomials of method A.12.
#pragma once
#include "kernels/math/symmetric.h"

namespace tessera {

inline constexpr int kMaxShDegree = 3;
inline constexpr int kMaxShCoefficients = 16;
inline constexpr double kSh0 = 0.28209479177387814;  // Y_0: colour = 0.5 + kSh0·c_0

TESSERA_HD inline constexpr int sh_coefficients(int degree) {
  return (degree + 1) * (degree + 1);
}

/// Highest degree that `coefficients` stored values allow.
TESSERA_HD inline constexpr int sh_degree_of(int coefficients) {
  int degree = 0;
  while (sh_coefficients(degree + 1) <= coefficients) ++degree;
  return degree;
}

/// Y[0 … (degree+1)²) at the unit direction d.
template <class Real>
TESSERA_HD inline void sh_basis(int degree, const Vec3<Real>& d, Real* Y) {
  const Real x = d[0], y = d[1], z = d[2];
  Y[0] = Real(kSh0);
  if (degree < 1) return;
  Y[1] = Real(-0.48860251190291987) * y;
  Y[2] = Real(0.48860251190291987) * z;
  Y[3] = Real(-0.48860251190291987) * x;
  if (degree < 2) return;
  Y[4] = Real(1.0925484305920792) * x * y;
  Y[5] = Real(-1.0925484305920792) * y * z;
  Y[6] = Real(0.94617469575755997) * z * z - Real(0.31539156525251999);
  Y[7] = Real(-1.0925484305920792) * x * z;
  Y[8] = Real(0.54627421529603959) * (x * x - y * y);
  if (degree < 3) return;
  Y[9] = y * (Real(0.59004358992664352) * y * y - Real(1.7701307697799304) * x * x);
  Y[10] = Real(2.8906114426405538) * x * y * z;
  Y[11] = y * (Real(0.45704579946446572) - Real(2.2852289973223288) * z * z);
  Y[12] = z * (Real(1.865881662950577) * z * z - Real(1.1195289977703462));
  Y[13] = x * (Real(0.45704579946446572) - Real(2.2852289973223288) * z * z);
  Y[14] = Real(1.4453057213202769) * z * (x * x - y * y);
  Y[15] = x * (Real(1.7701307697799304) * y * y - Real(0.59004358992664352) * x * x);
}

/// ∂Y/∂d of the polynomials above; only the part across d is meaningful.
template <class Real>
TESSERA_HD inline void sh_basis_gradient(int degree, const Vec3<Real>& d, Vec3<Real>* dY) {
  const Real x = d[0], y = d[1], z = d[2], o = Real(0);
  dY[0] = Vec3<Real>(o, o, o);
  if (degree < 1) return;
  const Real c1 = Real(0.48860251190291987);
  dY[1] = Vec3<Real>(o, -c1, o);
  dY[2] = Vec3<Real>(o, o, c1);
  dY[3] = Vec3<Real>(-c1, o, o);
  if (degree < 2) return;
  const Real c2 = Real(1.0925484305920792);
  dY[4] = Vec3<Real>(c2 * y, c2 * x, o);
  dY[5] = Vec3<Real>(o, -c2 * z, -c2 * y);
  dY[6] = Vec3<Real>(o, o, Real(2 * 0.94617469575755997) * z);
  dY[7] = Vec3<Real>(-c2 * z, o, -c2 * x);
  dY[8] = Vec3<Real>(c2 * x, -c2 * y, o);
  if (degree < 3) return;
  const Real a = Real(0.59004358992664352), b = Real(1.7701307697799304);
  const Real c = Real(2.8906114426405538), e = Real(0.45704579946446572);
  const Real f = Real(2.2852289973223288), g = Real(1.4453057213202769);
  dY[9] = Vec3<Real>(Real(-2) * b * x * y, Real(3) * a * y * y - b * x * x, o);
  dY[10] = Vec3<Real>(c * y * z, c * x * z, c * x * y);
  dY[11] = Vec3<Real>(o, e - f * z * z, Real(-2) * f * y * z);
  dY[12] = Vec3<Real>(o, o, Real(3 * 1.865881662950577) * z * z - Real(1.1195289977703462));
  dY[13] = Vec3<Real>(e - f * z * z, o, Real(-2) * f * x * z);
  dY[14] = Vec3<Real>(Real(2) * g * x * z, Real(-2) * g * y * z, g * (x * x - y * y));
  dY[15] = Vec3<Real>(b * y * y - Real(3) * a * x * x, Real(2) * b * x * y, o);
}

/// Un-clamped colour 0.5 + Σ Y_k c_k; the drawn colour is max(0, ·) per channel.
template <class Real>
TESSERA_HD inline Vec3<Real> sh_colour(int degree, const Vec3<Real>& direction,
                                       const Real* coefficients) {
  Real Y[kMaxShCoefficients] = {};
  sh_basis(degree, direction, Y);
  Vec3<Real> colour(Real(0.5), Real(0.5), Real(0.5));
  TESSERA_UNROLL
  for (int k = 0; k < kMaxShCoefficients; ++k) {
    if (k >= sh_coefficients(degree)) break;
    for (int c = 0; c < 3; ++c) colour[c] += Y[k] * coefficients[3 * k + c];
  }
  return colour;
}

/// How the un-clamped colour of a Gaussian follows its mean through the viewing direction
/// d = (mean − eye)/‖mean − eye‖. By the coefficients the gradient is Y_k(d) ⊗ d_colour: rank 1, so
/// it is not stored.
template <class Real>
struct alignas(16) ColourSlope {
  Vec3<Real> channel[3];  // ∂ of channel c by the mean, per world unit
  Vec3<Real> direction;   // d

  /// dL/d(mean) for dL/d(un-clamped colour).
  TESSERA_HD Vec3<Real> backward(const Vec3<Real>& d_colour) const {
    return channel[0] * d_colour[0] + channel[1] * d_colour[1] + channel[2] * d_colour[2];
  }
};

/// Of a Gaussian `distance` away: (I − d dᵀ) Σ_k c_k ∂Y_k/∂d / ‖mean − eye‖.
template <class Real>
TESSERA_HD inline ColourSlope<Real> colour_slope(int degree, const Vec3<Real>& direction,
                                                 Real distance, const Real* coefficients) {
  Vec3<Real> dY[kMaxShCoefficients] = {};
  sh_basis_gradient(degree, direction, dY);
  Vec3<Real> u[3] = {Vec3<Real>(Real(0)), Vec3<Real>(Real(0)), Vec3<Real>(Real(0))};
  TESSERA_UNROLL
  for (int k = 1; k < kMaxShCoefficients; ++k) {
    if (k >= sh_coefficients(degree)) break;
    for (int c = 0; c < 3; ++c) u[c] += dY[k] * coefficients[3 * k + c];
  }
  ColourSlope<Real> slope;
  const Real inverse = Real(1) / distance;
  for (int c = 0; c < 3; ++c)
    slope.channel[c] = (u[c] - direction * dot(direction, u[c])) * inverse;
  slope.direction = direction;
  return slope;
}

}  // namespace tessera
