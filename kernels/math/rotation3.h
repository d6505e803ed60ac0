// Quaternion to 3×3 rotation and covariance of a 3D Gaussian, with gradients. Source: [3DGS] Eq. 6;
// gradient: method A.12.
#pragma once
#include "kernels/math/symmetric.h"

namespace tessera {

// A quaternion is a Vec4 in the order (w, x, y, z), not necessarily of length 1.

/// ‖q‖² below this is not a rotation  [method A.5].
template <class Real>
inline constexpr Real kMinQuaternionNorm2 = Real(1e-8);

template <class Real>
TESSERA_HD inline Mat3<Real> rotation_matrix(const Vec4<Real>& q) {
  const Real s = Real(2) / dot(q, q);
  const Real w = q[0], x = q[1], y = q[2], z = q[3];
  return Mat3<Real>(                                                            // column by column
      Real(1) - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y),  //
      s * (x * y - w * z), Real(1) - s * (x * x + z * z), s * (y * z + w * x),  //
      s * (x * z + w * y), s * (y * z - w * x), Real(1) - s * (x * x + y * y));
}

/// d_q from d_R = dL/dR (any 3×3, m[column][row]).
template <class Real>
TESSERA_HD inline Vec4<Real> rotation_matrix_backward(const Vec4<Real>& q, const Mat3<Real>& d_R) {
  const Real w = q[0], x = q[1], y = q[2], z = q[3];
  const auto M = [&d_R](int r, int c) { return d_R[c - 1][r - 1]; };  // 1-based as in A.12
  const Real a1 = M(3, 2) - M(2, 3), a2 = M(1, 3) - M(3, 1), a3 = M(2, 1) - M(1, 2);
  const Real s12 = M(2, 1) + M(1, 2), s13 = M(1, 3) + M(3, 1), s23 = M(3, 2) + M(2, 3);
  const Real k1 = M(2, 2) + M(3, 3), k2 = M(1, 1) + M(3, 3), k3 = M(1, 1) + M(2, 2);
  const Real f = Real(2) / dot(q, q);
  const Real D = f * (x * y * s12 + x * z * s13 + y * z * s23 + w * x * a1 + w * y * a2 +
                      w * z * a3 - x * x * k1 - y * y * k2 - z * z * k3);
  return Vec4<Real>(f * (x * a1 + y * a2 + z * a3 - w * D),
                    f * (w * a1 - Real(2) * x * k1 + y * s12 + z * s13 - x * D),
                    f * (w * a2 + x * s12 - Real(2) * y * k2 + z * s23 - y * D),
                    f * (w * a3 + x * s13 + y * s23 - Real(2) * z * k3 - z * D));
}

/// e^{2·log_scale}: the variances along the axes.
template <class Real>
TESSERA_HD inline Vec3<Real> variances(const Vec3<Real>& log_scale) {
  return Vec3<Real>(exp(Real(2) * log_scale[0]), exp(Real(2) * log_scale[1]),
                    exp(Real(2) * log_scale[2]));
}

/// Σ = R diag(e^{2 s̃}) Rᵀ: gradients by s̃ and q, from d_cov in the symmetric convention.
template <class Real>
TESSERA_HD inline void covariance3_backward(const Vec4<Real>& q, const Vec3<Real>& log_scale,
                                            const Sym3<Real>& d_cov, Vec4<Real>& d_q,
                                            Vec3<Real>& d_log_scale) {
  const Mat3<Real> R = rotation_matrix(q);
  const Vec3<Real> v = variances(log_scale);
  Mat3<Real> d_R;
  for (int k = 0; k < 3; ++k) {
    const Vec3<Real> column = d_cov * Vec3<Real>(R[k]);
    d_log_scale[k] = Real(2) * v[k] * dot(Vec3<Real>(R[k]), column);
    for (int r = 0; r < 3; ++r) d_R[k][r] = Real(2) * v[k] * column[r];
  }
  d_q = rotation_matrix_backward(q, d_R);
}

}  // namespace tessera
