// Exact rotation of spherical harmonics to degree 3. Source: the bands are invariant under
// rotation; their matrices are the inner products ∫ Y_j(Rᵀd) Y_k(d) dd by Gauss-Legendre nodes in z
// and equal steps of azimuth, which is exact for products of degree 6.
#pragma once
#include <array>

#include "kernels/math/spherical_harmonics.h"

namespace tessera {

class ShRotation {
 public:
  /// `b_from_a`: a proper rotation.
  explicit ShRotation(const Mat3<double>& b_from_a);

  /// Coefficients [K, 3] of a colour seen along directions of world a → those that give the same
  /// colour along the turned directions of world b. K: 1, 4, 9 or 16.
  void apply(int coefficients, float* sh) const;
  /// The same in double.
  void apply(int coefficients, double* sh) const;

 private:
  // [k][j]: what coefficient j of world a gives to k of world b; zero across bands.
  std::array<std::array<double, kMaxShCoefficients>, kMaxShCoefficients> matrix_{};
};

}  // namespace tessera
