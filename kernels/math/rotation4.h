// Two quaternions to the rotation of space-time x ↦ l·x·r on (t, x, y, z), and its gradient. Both
// quaternions are normalised here, so any length above 0 is accepted. A static Gaussian has r =
// conj(l); the spatial block is then rotation_matrix(l). Source: [Yang24] Eq. 7 with time on the
// real axis (Deviation: the published code has x on the real axis; `published_from_ours` converts);
// gradient: method D.2.
#pragma once
#include "kernels/math/symmetric.h"

namespace tessera {

/// Row-major 4×4 on (t, x, y, z).
template <class Real>
struct Mat4 {
  Real m[4][4];
};

/// y ↦ l·y as a matrix.
template <class Real>
TESSERA_HD inline Mat4<Real> left_matrix(const Vec4<Real>& l) {
  const Real a = l[0], b = l[1], c = l[2], d = l[3];
  return {{{a, -b, -c, -d}, {b, a, -d, c}, {c, d, a, -b}, {d, -c, b, a}}};
}
/// y ↦ y·r as a matrix.
template <class Real>
TESSERA_HD inline Mat4<Real> right_matrix(const Vec4<Real>& r) {
  const Real p = r[0], q = r[1], s = r[2], u = r[3];
  return {{{p, -q, -s, -u}, {q, p, u, -s}, {s, -u, p, q}, {u, s, -q, p}}};
}
template <class Real>
TESSERA_HD inline Vec4<Real> normalised(const Vec4<Real>& q) {
  return q / sqrt(dot(q, q));
}
template <class Real>
TESSERA_HD inline Vec4<Real> conjugate(const Vec4<Real>& q) {
  return Vec4<Real>(q[0], -q[1], -q[2], -q[3]);
}

template <class Real>
TESSERA_HD inline Mat4<Real> multiply(const Mat4<Real>& a, const Mat4<Real>& b) {
  Mat4<Real> c;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      c.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j] +
                  a.m[i][3] * b.m[3][j];
  return c;
}
template <class Real>
TESSERA_HD inline Mat4<Real> transposed(const Mat4<Real>& a) {
  Mat4<Real> t;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) t.m[i][j] = a.m[j][i];
  return t;
}

/// R = L(l/‖l‖)·Q(r/‖r‖).
template <class Real>
TESSERA_HD inline Mat4<Real> rotation4(const Vec4<Real>& l, const Vec4<Real>& r) {
  return multiply(left_matrix(normalised(l)), right_matrix(normalised(r)));
}

/// Gradient through x̂ = x/‖x‖.
template <class Real>
TESSERA_HD inline Vec4<Real> normalised_backward(const Vec4<Real>& x, const Vec4<Real>& d_unit) {
  const Real inverse = Real(1) / sqrt(dot(x, x));
  const Vec4<Real> unit = x * inverse;
  return (d_unit - unit * dot(d_unit, unit)) * inverse;
}

/// d_l, d_r from d_R = dL/dR.
template <class Real>
TESSERA_HD inline void rotation4_backward(const Vec4<Real>& l, const Vec4<Real>& r,
                                          const Mat4<Real>& d_R, Vec4<Real>& d_l, Vec4<Real>& d_r) {
  const Mat4<Real> L = left_matrix(normalised(l)), Q = right_matrix(normalised(r));
  const Mat4<Real> M4 = multiply(d_R, transposed(Q));
  const auto& M = M4.m;
  const Vec4<Real> d_l_unit(
      M[0][0] + M[1][1] + M[2][2] + M[3][3], M[1][0] - M[0][1] + M[3][2] - M[2][3],
      M[2][0] - M[0][2] + M[1][3] - M[3][1], M[3][0] - M[0][3] + M[2][1] - M[1][2]);
  const Mat4<Real> N4 = multiply(transposed(L), d_R);
  const auto& N = N4.m;
  const Vec4<Real> d_r_unit(
      N[0][0] + N[1][1] + N[2][2] + N[3][3], N[1][0] - N[0][1] - N[3][2] + N[2][3],
      N[2][0] - N[0][2] - N[1][3] + N[3][1], N[3][0] - N[0][3] - N[2][1] + N[1][2]);
  d_l = normalised_backward(l, d_l_unit);
  d_r = normalised_backward(r, d_r_unit);
}

}  // namespace tessera
