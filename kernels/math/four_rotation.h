// The axes of a 4D Gaussian from any four vectors that span it or after a scale of space alone, and
// the two quaternions of a rotation of space-time. In double: conversions and splits need them once
// for each Gaussian. Source: [GolubVanLoan] one-sided Jacobi (section 8.6.3): small axes keep their
// relative accuracy.
#pragma once
#include "kernels/math/rotation4.h"

namespace tessera {

/// Makes columns p and q orthogonal; false where they are, to rounding.
TESSERA_HD inline bool orthogonalise(Mat4<double>& A, int p, int q) {
  constexpr double kOrthogonal = 1e-15;
  double pp = 0, qq = 0, pq = 0;
  for (int i = 0; i < 4; ++i) {
    pp += A.m[i][p] * A.m[i][p];
    qq += A.m[i][q] * A.m[i][q];
    pq += A.m[i][p] * A.m[i][q];
  }
  if (!(abs_of(pq) > kOrthogonal * sqrt(pp * qq))) return false;
  const double zeta = (qq - pp) / (2 * pq);
  const double t = copysign(1 / (abs_of(zeta) + sqrt(1 + zeta * zeta)), zeta);
  const double c = 1 / sqrt(1 + t * t), s = c * t;
  for (int i = 0; i < 4; ++i) {
    const double x = A.m[i][p], y = A.m[i][q];
    A.m[i][p] = c * x - s * y;
    A.m[i][q] = s * x + c * y;
  }
  return true;
}

TESSERA_HD inline Vec4<double> unit_vector4(int k) {
  Vec4<double> e(0.0);
  e[k] = 1;
  return e;
}

/// Unit (l, r), up to a common sign, with rotation4(l, r) = R for a proper rotation R.
TESSERA_HD inline void quaternions_of_rotation4(const Mat4<double>& R, Vec4<double>& left,
                                                Vec4<double>& right) {
  // The matrices L(e_i)·Q(e_j) are orthogonal to each other, with squared norm 4: the products
  // with R are l_i·r_j, and any element is r up to its length.
  double lr[4][4] = {};
  int largest = 0;
  double largest_square = -1;
  for (int i = 0; i < 4; ++i) {
    double square = 0;
    for (int j = 0; j < 4; ++j) {
      const Mat4<double> basis =
          multiply(left_matrix(unit_vector4(i)), right_matrix(unit_vector4(j)));
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) lr[i][j] += 0.25 * basis.m[a][b] * R.m[a][b];
      square += lr[i][j] * lr[i][j];
    }
    if (square > largest_square) {
      largest = i;
      largest_square = square;
    }
  }
  right = normalised(Vec4<double>(lr[largest][0], lr[largest][1], lr[largest][2], lr[largest][3]));
  for (int i = 0; i < 4; ++i)
    left[i] = lr[i][0] * right[0] + lr[i][1] * right[1] + lr[i][2] * right[2] + lr[i][3] * right[3];
  left = normalised(left);
}

/// Axes of x ↦ left·x·right, standard deviations along them, time's first.
struct Shape4 {
  Vec4<double> left, right;
  Vec4<double> sigma;
};

/// The axes of the Gaussian A·z, z ~ N(0, I₄), on (t, x, y, z). Needs det A > 0.
TESSERA_HD inline Shape4 shape_of(Mat4<double> A) {
  constexpr int kMaxSweeps = 30;  // quadratic convergence: 4 to 8 suffice
  bool turned = true;
  for (int sweep = 0; sweep < kMaxSweeps && turned; ++sweep) {
    turned = false;
    for (int p = 0; p < 4; ++p)
      for (int q = p + 1; q < 4; ++q) turned |= orthogonalise(A, p, q);
  }
  Shape4 shape;
  for (int k = 0; k < 4; ++k) {
    double square = 0;
    for (int i = 0; i < 4; ++i) square += A.m[i][k] * A.m[i][k];
    shape.sigma[k] = sqrt(square);
    for (int i = 0; i < 4; ++i) A.m[i][k] /= shape.sigma[k];
  }
  quaternions_of_rotation4(A, shape.left, shape.right);
  return shape;
}

/// Stretches the three spatial directions by `scale` > 0. False, and nothing changed, where the
/// axes stay as they are because none mixes space and time.
TESSERA_HD inline bool scale_space(double scale, Shape4& shape) {
  // Axes that mix by less than a float's rounding of the quaternions are pure: a lifted static
  // Gaussian stays one, to the bit.
  constexpr double kPure = 1e-6;
  Mat4<double> A = rotation4(shape.left, shape.right);
  if (scale == 1 || abs_of(A.m[0][0]) > 1 - 0.5 * kPure * kPure) return false;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) A.m[i][k] *= (i == 0 ? 1 : scale) * shape.sigma[k];
  shape = shape_of(A);
  return true;
}

}  // namespace tessera
