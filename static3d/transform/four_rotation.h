// The axes of a 4D Gaussian from any four vectors that span it or after a scale of space alone, and
// the two quaternions of a rotation of space-time. Conversions need them once for each Gaussian, in
// double. Source: [GolubVanLoan] one-sided Jacobi (section 8.6.3): small axes keep their relative
// accuracy.
#pragma once
#include "kernels/math/rotation4.h"

namespace tessera {

/// Unit (l, r), up to a common sign, with rotation4(l, r) = R for a proper rotation R.
void quaternions_of_rotation4(const Mat4<double>& R, Vec4<double>& left, Vec4<double>& right);

/// Axes of x ↦ left·x·right, standard deviations along them, time's first.
struct Shape4 {
  Vec4<double> left, right;
  Vec4<double> sigma;
};

/// The axes of the Gaussian A·z, z ~ N(0, I₄), on (t, x, y, z). Needs det A > 0.
Shape4 shape_of(Mat4<double> A);

/// Stretches the three spatial directions by `scale` > 0. False, and nothing changed, where the
/// axes stay as they are because none mixes space and time.
bool scale_space(double scale, Shape4& shape);

}  // namespace tessera
