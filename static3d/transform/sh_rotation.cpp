// The matrices of the SH bands by quadrature, and their product with coefficients. The signs follow
// from the basis in kernels/math/spherical_harmonics.h.
#include "static3d/transform/sh_rotation.h"

#include <cmath>

namespace tessera {
namespace {

// Gauss-Legendre with four nodes is exact to degree 7, eight azimuths likewise: products of two
// functions of degree 3 have degree 6.
constexpr int kAzimuths = 8;
constexpr double kPi = 3.14159265358979323846;

struct Node {
  double z, weight;  // weights of the four sum to 2
};

std::array<Node, 4> gauss_legendre4() {
  const double root = 2.0 / 7 * std::sqrt(6.0 / 5), share = std::sqrt(30.0) / 36;
  const double inner = std::sqrt(3.0 / 7 - root), outer = std::sqrt(3.0 / 7 + root);
  return {
      {{-outer, 0.5 - share}, {-inner, 0.5 + share}, {inner, 0.5 + share}, {outer, 0.5 - share}}};
}

template <class Real>
void multiply_bands(
    const std::array<std::array<double, kMaxShCoefficients>, kMaxShCoefficients>& matrix,
    int coefficients, Real* sh) {
  double turned[kMaxShCoefficients][3] = {};
  for (int degree = 0; sh_coefficients(degree) <= coefficients; ++degree)
    for (int k = degree * degree; k < sh_coefficients(degree); ++k)
      for (int j = degree * degree; j < sh_coefficients(degree); ++j)
        for (int c = 0; c < 3; ++c)
          turned[k][c] += matrix[size_t(k)][size_t(j)] * double(sh[3 * j + c]);
  for (int k = 1; k < coefficients; ++k)  // band 0 is the same in all directions
    for (int c = 0; c < 3; ++c) sh[3 * k + c] = Real(turned[k][c]);
}

}  // namespace

ShRotation::ShRotation(const Mat3<double>& b_from_a) {
  const Mat3<double> a_from_b = glm::transpose(b_from_a);
  for (const Node& node : gauss_legendre4())
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = 2 * kPi * (i + 0.5) / kAzimuths,
                   across = std::sqrt(1 - node.z * node.z);
      const Vec3<double> d(across * std::cos(azimuth), across * std::sin(azimuth), node.z);
      double of_a[kMaxShCoefficients], of_b[kMaxShCoefficients];
      sh_basis(kMaxShDegree, a_from_b * d, of_a);
      sh_basis(kMaxShDegree, d, of_b);
      const double weight = node.weight * 2 * kPi / kAzimuths;
      for (int degree = 0; degree <= kMaxShDegree; ++degree)
        for (int k = degree * degree; k < sh_coefficients(degree); ++k)
          for (int j = degree * degree; j < sh_coefficients(degree); ++j)
            matrix_[size_t(k)][size_t(j)] += weight * of_b[k] * of_a[j];
    }
}

void ShRotation::apply(int coefficients, float* sh) const {
  multiply_bands(matrix_, coefficients, sh);
}

void ShRotation::apply(int coefficients, double* sh) const {
  multiply_bands(matrix_, coefficients, sh);
}

}  // namespace tessera
