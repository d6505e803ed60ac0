// Axes of an ellipsoid in space-time by one-sided Jacobi rotations, and a rotation of space-time as
// two quaternions: the inverse of rotation4. In double: splits need it once per Gaussian. Source:
// [GolubVanLoan] one-sided Jacobi.
#pragma once
#include "kernels/math/rotation4.h"

namespace tessera {

struct Shape4 {
  Vec4<double> left, right;  // unit quaternions
  Vec4<double> log_length;   // of the axes, the first of time
};

/// Turns pairs of columns until all are orthogonal: columns of A become those of A·V, whose lengths
/// and directions are the standard deviations and the axes of A·Aᵀ  [GolubVanLoan, one-sided
/// Jacobi]. det A keeps its sign.
TESSERA_HD inline void make_orthogonal(double (&column)[4][4]) {
  constexpr int kMaxSweeps = 16;
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool turned = false;
    for (int p = 0; p < 3; ++p)
      for (int q = p + 1; q < 4; ++q) {
        double pp = 0, qq = 0, pq = 0;
        for (int i = 0; i < 4; ++i) {
          pp += column[p][i] * column[p][i];
          qq += column[q][i] * column[q][i];
          pq += column[p][i] * column[q][i];
        }
        if (!(pq * pq > 1e-28 * pp * qq)) continue;
        turned = true;
        const double theta = (qq - pp) / (2 * pq);
        const double t = (theta < 0 ? -1.0 : 1.0) / (abs_of(theta) + sqrt(theta * theta + 1));
        const double c = 1 / sqrt(t * t + 1), s = t * c;
        for (int i = 0; i < 4; ++i) {
          const double old = column[p][i];
          column[p][i] = c * old - s * column[q][i];
          column[q][i] = s * old + c * column[q][i];
        }
      }
    if (!turned) return;
  }
}

/// Unit l, r with rotation4(l, r) = R: l_i·r_j = ⟨R, L(e_i)·Q(e_j)⟩/4, of which the row and the
/// column through the largest are r and l.
TESSERA_HD inline void quaternions_of(const Mat4<double>& R, Vec4<double>& l, Vec4<double>& r) {
  double product[4][4];
  int row = 0, col = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      Vec4<double> e(0.0), f(0.0);
      e[i] = f[j] = 1;
      const Mat4<double> B = multiply(left_matrix(e), right_matrix(f));
      product[i][j] = 0;
      for (int k = 0; k < 16; ++k) product[i][j] += R.m[k / 4][k % 4] * B.m[k / 4][k % 4] / 4;
      if (abs_of(product[i][j]) > abs_of(product[row][col])) row = i, col = j;
    }
  for (int k = 0; k < 4; ++k) {
    l[k] = product[k][col];
    r[k] = product[row][k];
  }
  l = normalised(l);
  r = normalised(r);
  if (product[row][col] * l[row] * r[col] < 0) r = -r;
}

/// Of Σ₄ = A·Aᵀ, A = [column 0 … 3] on (t, x, y, z) with det A > 0.
TESSERA_HD inline Shape4 shape_of_columns(double (&column)[4][4]) {
  make_orthogonal(column);
  Shape4 shape;
  Mat4<double> R;
  for (int k = 0; k < 4; ++k) {
    double square = 0;
    for (int i = 0; i < 4; ++i) square += column[k][i] * column[k][i];
    shape.log_length[k] = 0.5 * log(square);
    for (int i = 0; i < 4; ++i) R.m[i][k] = column[k][i] / sqrt(square);
  }
  quaternions_of(R, shape.left, shape.right);
  return shape;
}

}  // namespace tessera
