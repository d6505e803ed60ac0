// Packed symmetric matrices (2×2, 3×3) and the products that splatting needs. Gradients by a
// symmetric matrix use the "symmetric convention": the stored off-diagonal gradient is one of the
// two equal entries, so ⟨G, dΣ⟩ counts it twice.
#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "kernels/math/scalar.h"

namespace tessera {

template <class Real>
using Vec2 = glm::vec<2, Real>;
template <class Real>
using Vec3 = glm::vec<3, Real>;
template <class Real>
using Vec4 = glm::vec<4, Real>;
template <class Real>
using Mat3 = glm::mat<3, 3, Real>;

template <class Real>
TESSERA_HD inline Real dot(const Vec3<Real>& a, const Vec3<Real>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class Real>
TESSERA_HD inline Real dot(const Vec4<Real>& a, const Vec4<Real>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}
/// Row r of a matrix.
template <class Real>
TESSERA_HD inline Vec3<Real> row(const Mat3<Real>& m, int r) {
  return Vec3<Real>(m[0][r], m[1][r], m[2][r]);
}

template <class Real>
struct Sym2 {
  Real xx{}, xy{}, yy{};

  TESSERA_HD Sym2& operator+=(const Sym2& o) {
    xx += o.xx;
    xy += o.xy;
    yy += o.yy;
    return *this;
  }
};

template <class Real>
struct Sym3 {
  Real xx{}, xy{}, xz{}, yy{}, yz{}, zz{};

  TESSERA_HD Vec3<Real> operator*(const Vec3<Real>& v) const {
    return Vec3<Real>(xx * v[0] + xy * v[1] + xz * v[2], xy * v[0] + yy * v[1] + yz * v[2],
                      xz * v[0] + yz * v[1] + zz * v[2]);
  }
  TESSERA_HD Sym3& operator+=(const Sym3& o) {
    xx += o.xx;
    xy += o.xy;
    xz += o.xz;
    yy += o.yy;
    yz += o.yz;
    zz += o.zz;
    return *this;
  }
};

/// R diag(v) Rᵀ.
template <class Real>
TESSERA_HD inline Sym3<Real> rotate_diagonal(const Mat3<Real>& R, const Vec3<Real>& v) {
  Sym3<Real> s;
  const Vec3<Real> c0 = R[0], c1 = R[1], c2 = R[2];
  s.xx = v[0] * c0[0] * c0[0] + v[1] * c1[0] * c1[0] + v[2] * c2[0] * c2[0];
  s.xy = v[0] * c0[0] * c0[1] + v[1] * c1[0] * c1[1] + v[2] * c2[0] * c2[1];
  s.xz = v[0] * c0[0] * c0[2] + v[1] * c1[0] * c1[2] + v[2] * c2[0] * c2[2];
  s.yy = v[0] * c0[1] * c0[1] + v[1] * c1[1] * c1[1] + v[2] * c2[1] * c2[1];
  s.yz = v[0] * c0[1] * c0[2] + v[1] * c1[1] * c1[2] + v[2] * c2[1] * c2[2];
  s.zz = v[0] * c0[2] * c0[2] + v[1] * c1[2] * c1[2] + v[2] * c2[2] * c2[2];
  return s;
}

/// a bᵀ + b aᵀ in packed form, halved on the off-diagonal by the symmetric convention:
/// the gradient of aᵀ Σ b by Σ.
template <class Real>
TESSERA_HD inline Sym3<Real> symmetric_outer(const Vec3<Real>& a, const Vec3<Real>& b) {
  const Real half = Real(0.5);
  return {a[0] * b[0], half * (a[0] * b[1] + a[1] * b[0]), half * (a[0] * b[2] + a[2] * b[0]),
          a[1] * b[1], half * (a[1] * b[2] + a[2] * b[1]), a[2] * b[2]};
}

template <class Real>
TESSERA_HD inline Sym3<Real> operator*(Real f, const Sym3<Real>& s) {
  return {f * s.xx, f * s.xy, f * s.xz, f * s.yy, f * s.yz, f * s.zz};
}

}  // namespace tessera
