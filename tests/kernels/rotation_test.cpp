// Rotations of space and space-time, their covariance, their gradients and the conversion to the
// published convention.
#include "kernels/math/rotation4.h"

#include "kernels/math/rotation3.h"
#include "tests/kernels/published_rotation.h"
#include "tests/support/dual.h"
#include "tests/support/random.h"

namespace tessera::testing {
namespace {

constexpr double kTolerance = 1e-12;  // some hundred roundings of numbers of order 1

template <class Real, size_t N>
Vec4<Real> quaternion(const std::array<Real, N>& p, size_t first = 0) {
  return Vec4<Real>(p[first], p[first + 1], p[first + 2], p[first + 3]);
}

/// Hamilton product, the definition that left_matrix and right_matrix are tested against.
Vec4<double> product(const Vec4<double>& a, const Vec4<double>& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

TEST(Rotation3, TurnsVectorsAsTheQuaternionProductDoes) {
  Random random(1);
  for (int round = 0; round < 20; ++round) {
    const Vec4<double> q = quaternion(random.array<4>(-2, 2));
    const auto v = random.array<3>(-1, 1);
    const Vec4<double> unit = normalised(q);
    const Vec4<double> turned =
        product(product(unit, Vec4<double>(0, v[0], v[1], v[2])), conjugate(unit));
    const Vec3<double> by_matrix = rotation_matrix(q) * Vec3<double>(v[0], v[1], v[2]);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(by_matrix[i], turned[i + 1], kTolerance);
  }
}

TEST(Rotation3, BackwardEqualsDuals) {
  Random random(2);
  for (int round = 0; round < 20; ++round) {
    const auto x = random.array<4>(-2, 2);
    const auto weight = random.array<9>(-1, 1);
    const auto expected = dual_gradient(x, [&](const auto& p) {
      const Mat3<Dual> R = rotation_matrix(quaternion(p));
      Dual loss = 0;
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) loss += R[c][r] * weight[size_t(3 * c + r)];
      return loss;
    });
    Mat3<double> d_R;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) d_R[c][r] = weight[size_t(3 * c + r)];
    const Vec4<double> actual = rotation_matrix_backward(quaternion(x), d_R);
    expect_near_all(std::array{actual[0], actual[1], actual[2], actual[3]}, expected, kTolerance,
                    "d_q");
  }
}

TEST(Rotation3, CovarianceBackwardEqualsDuals) {
  Random random(3);
  for (int round = 0; round < 20; ++round) {
    auto x = random.array<7>(-1, 1);
    const auto g = random.array<6>(-1, 1);
    const auto expected = dual_gradient(x, [&](const auto& p) {
      const Sym3<Dual> s =
          rotate_diagonal(rotation_matrix(quaternion(p)), variances(Vec3<Dual>(p[4], p[5], p[6])));
      return s.xx * g[0] + s.yy * g[3] + s.zz * g[5] +
             Dual(2) * (s.xy * g[1] + s.xz * g[2] + s.yz * g[4]);
    });
    Vec4<double> d_q;
    Vec3<double> d_log;
    covariance3_backward(quaternion(x), Vec3<double>(x[4], x[5], x[6]),
                         Sym3<double>{g[0], g[1], g[2], g[3], g[4], g[5]}, d_q, d_log);
    expect_near_all(std::array{d_q[0], d_q[1], d_q[2], d_q[3], d_log[0], d_log[1], d_log[2]},
                    expected, kTolerance, "d_q, d_log_scale");
  }
}

TEST(Rotation4, IsTheQuaternionProductFromBothSides) {
  Random random(4);
  const Vec4<double> l = quaternion(random.array<4>(-1, 1)), r = quaternion(random.array<4>(-1, 1));
  const Mat4<double> R = rotation4(l, r);
  for (int k = 0; k < 4; ++k) {
    Vec4<double> axis(0.0);
    axis[k] = 1;
    const Vec4<double> image = product(product(normalised(l), axis), normalised(r));
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(R.m[i][k], image[i], kTolerance);
  }
}

TEST(Rotation4, StaticWhenRightIsConjugateOfLeft) {
  Random random(5);
  for (int round = 0; round < 20; ++round) {
    const Vec4<double> l = quaternion(random.array<4>(-2, 2));
    const Mat4<double> R = rotation4(l, conjugate(l));
    const Mat3<double> space = rotation_matrix(l);
    EXPECT_NEAR(R.m[0][0], 1, kTolerance);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(R.m[0][i + 1], 0, kTolerance);
      EXPECT_NEAR(R.m[i + 1][0], 0, kTolerance);
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(R.m[i + 1][j + 1], space[j][i], kTolerance);
    }
  }
}

TEST(Rotation4, BackwardEqualsDuals) {
  Random random(6);
  for (int round = 0; round < 20; ++round) {
    const auto x = random.array<8>(-2, 2);
    const auto weight = random.array<16>(-1, 1);
    const auto expected = dual_gradient(x, [&](const auto& p) {
      const Mat4<Dual> R = rotation4(quaternion(p), quaternion(p, 4));
      Dual loss = 0;
      for (int i = 0; i < 16; ++i) loss += R.m[i / 4][i % 4] * weight[size_t(i)];
      return loss;
    });
    Mat4<double> d_R;
    for (int i = 0; i < 16; ++i) d_R.m[i / 4][i % 4] = weight[size_t(i)];
    Vec4<double> d_l, d_r;
    rotation4_backward(quaternion(x), quaternion(x, 4), d_R, d_l, d_r);
    expect_near_all(std::array{d_l[0], d_l[1], d_l[2], d_l[3], d_r[0], d_r[1], d_r[2], d_r[3]},
                    expected, kTolerance, "d_l, d_r");
  }
}

/// R on (x, y, z, t) from R on (t, x, y, z): P·R·Pᵀ with P the cyclic re-ordering.
Mat4<double> time_last(const Mat4<double>& R) {
  Mat4<double> out;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) out.m[i][j] = R.m[(i + 1) % 4][(j + 1) % 4];
  return out;
}

TEST(Rotation4, PublishedConventionIsTheSameRotationReordered) {
  // Bug put back: sign of published_l[1] flipped; seen to fail.
  Random random(7);
  for (int round = 0; round < 20; ++round) {
    const Vec4<double> l = quaternion(random.array<4>(-1, 1)),
                       r = quaternion(random.array<4>(-1, 1));
    Vec4<double> published_l, published_r, back_l, back_r;
    published_from_ours(l, r, published_l, published_r);
    const Mat4<double> expected = time_last(rotation4(l, r));
    const Mat4<double> actual = rotation4(published_l, published_r);
    for (int i = 0; i < 16; ++i)
      EXPECT_NEAR(actual.m[i / 4][i % 4], expected.m[i / 4][i % 4], kTolerance);
    ours_from_published(published_l, published_r, back_l, back_r);
    for (int i = 0; i < 4; ++i) {
      EXPECT_EQ(back_l[i], l[i]);
      EXPECT_EQ(back_r[i], r[i]);
    }
  }
}

TEST(Rotation4, OursFromPublishedIsTheSameRotationReordered) {
  Random random(8);
  for (int round = 0; round < 20; ++round) {
    const Vec4<double> published_l = quaternion(random.array<4>(-1, 1)),
                       published_r = quaternion(random.array<4>(-1, 1));
    Vec4<double> l, r;
    ours_from_published(published_l, published_r, l, r);
    const Mat4<double> expected = rotation4(published_l, published_r);
    const Mat4<double> actual = time_last(rotation4(l, r));
    for (int i = 0; i < 16; ++i)
      EXPECT_NEAR(actual.m[i / 4][i % 4], expected.m[i / 4][i % 4], kTolerance);
  }
}

}  // namespace
}  // namespace tessera::testing
