// Axes of a symmetric 3×3 matrix by Jacobi rotations, a rotation matrix as a quaternion, and a
// covariance as the stored parameters of a static Gaussian. In double: slices, conversions and
// demotion need it once per Gaussian. Source: [GolubVanLoan] cyclic Jacobi; [Shepperd78] quaternion
// by its largest component.
#pragma once
#include "kernels/math/symmetric.h"

namespace tessera {

/// A = V diag(values) Vᵀ.
struct Eigen3 {
  Vec3<double> values;
  Mat3<double> vectors;  // columns, a proper rotation (det +1); identity for a diagonal A
};

/// One Jacobi rotation in the plane (p, q): zeroes a[p][q], turns V along.
TESSERA_HD inline void jacobi_rotate(double a[3][3], int p, int q, Mat3<double>& V) {
  if (a[p][q] == 0.0) return;
  const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
  const double t = (theta < 0 ? -1.0 : 1.0) / (abs_of(theta) + sqrt(theta * theta + 1.0));
  const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
  const int r = 3 - p - q;
  const double arp = a[r][p], arq = a[r][q];
  a[p][p] -= t * a[p][q];
  a[q][q] += t * a[p][q];
  a[p][q] = a[q][p] = 0.0;
  a[r][p] = a[p][r] = c * arp - s * arq;
  a[r][q] = a[q][r] = s * arp + c * arq;
  const Vec3<double> vp = V[p], vq = V[q];
  V[p] = vp * c - vq * s;
  V[q] = vp * s + vq * c;
}

/// Needs finite entries. Eigenvalues are in the order of the axes they grew from, not sorted.
TESSERA_HD inline Eigen3 symmetric_eigen(const Sym3<double>& m) {
  constexpr int kMaxSweeps = 16;  // quadratic convergence: 4 to 6 suffice
  double a[3][3] = {{m.xx, m.xy, m.xz}, {m.xy, m.yy, m.yz}, {m.xz, m.yz, m.zz}};
  Mat3<double> V(1.0);
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    if (a[0][1] == 0.0 && a[0][2] == 0.0 && a[1][2] == 0.0) break;
    jacobi_rotate(a, 0, 1, V);
    jacobi_rotate(a, 0, 2, V);
    jacobi_rotate(a, 1, 2, V);
  }
  return {Vec3<double>(a[0][0], a[1][1], a[2][2]), V};
}

/// Unit quaternion (w, x, y, z) of a proper rotation, w ≥ 0: the inverse of rotation_matrix.
TESSERA_HD inline Vec4<double> quaternion_from_rotation(const Mat3<double>& R) {
  const double xx = R[0][0], yy = R[1][1], zz = R[2][2];  // R[column][row]
  // 4·w², 4·x², 4·y², 4·z²
  const double square[4] = {1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz};
  int largest = 0;
  for (int k = 1; k < 4; ++k)
    if (square[k] > square[largest]) largest = k;
  const double wx = R[1][2] - R[2][1], wy = R[2][0] - R[0][2], wz = R[0][1] - R[1][0];
  const double xy = R[0][1] + R[1][0], xz = R[0][2] + R[2][0], yz = R[1][2] + R[2][1];
  const double diagonal = square[largest];
  const Vec4<double> rows[4] = {{diagonal, wx, wy, wz},
                                {wx, diagonal, xy, xz},
                                {wy, xy, diagonal, yz},
                                {wz, xz, yz, diagonal}};
  Vec4<double> q = rows[largest];
  q = q * (1.0 / sqrt(dot(q, q)));
  return q[0] < 0 ? -q : q;
}

struct Shape3 {
  Vec3<double> log_scale;  // ln of world units
  Vec4<double> rotation;   // unit quaternion w,x,y,z
};

/// Rounding may leave an eigenvalue at or below 0: deviations are at least 1e-12.
TESSERA_HD inline Shape3 shape_of(const Sym3<double>& covariance) {
  constexpr double kMinVariance = 1e-24;  // world units²: e^{2·log_scale} is a normal float
  const Eigen3 eigen = symmetric_eigen(covariance);
  Shape3 shape;
  for (int k = 0; k < 3; ++k) shape.log_scale[k] = 0.5 * log(max_of(eigen.values[k], kMinVariance));
  shape.rotation = quaternion_from_rotation(eigen.vectors);
  return shape;
}

}  // namespace tessera
