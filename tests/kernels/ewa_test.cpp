// The projection of a 3D Gaussian to a 2D one against a plain formula, and its gradient against
// dual numbers, inside and outside the margin where the Jacobian is clamped.
#include "kernels/math/ewa.h"

#include "tests/support/dual.h"
#include "tests/support/random.h"

namespace tessera::testing {
namespace {

template <class Real>
ViewArgs<Real> test_view() {
  ViewArgs<Real> view{};
  view.fl_x = Real(40);
  view.fl_y = Real(52);
  view.cx = Real(21);
  view.cy = Real(13);
  view.width = 44;
  view.height = 30;
  view.tiles_x = 3;
  view.tiles_y = 2;
  // a rotation: unit quaternion (0.5, 0.5, 0.5, 0.5) composed with a small turn
  const double c = 0.96, s = 0.28;
  view.cam_from_world =
      Mat3<Real>(Real(0), Real(c), Real(s), Real(0), Real(-s), Real(c), Real(1), Real(0), Real(0));
  view.translation = Vec3<Real>(Real(0.3), Real(-0.2), Real(0.1));
  return view;
}

/// World point that lands at the camera-space point (x, y, z).
Vec3<double> world_point(double x, double y, double z) {
  const ViewArgs<double> view = test_view<double>();
  return glm::transpose(view.cam_from_world) * (Vec3<double>(x, y, z) - view.translation);
}

struct Case {
  const char* name;
  double x, y, z;  // camera space
};

// the clamp is at x/z = (−6.6−21)/40 = −0.69 … 0.74, y/z = (−4.5−13)/52 = −0.337 … 0.413
constexpr Case kCases[] = {{"inside", 0.4, -0.3, 2.5},        {"left of the margin", -2.5, 0.1, 2},
                           {"right of the margin", 2, 0, 2},  {"above the margin", 0.2, -1.5, 2},
                           {"below the margin", 0.1, 1.2, 2}, {"outside both", -3, 1.5, 2}};

/// dL for a weighted sum of mean2d and conic, by the world mean and the covariance.
TEST(Ewa, BackwardEqualsDualsInsideAndOutsideTheMargin) {
  // Bug put back: factor 2 instead of (1 + v) in dZ, as 3DGS has it; seen to fail.
  Random random(1);
  for (const Case& c : kCases) {
    const Vec3<double> mean = world_point(c.x, c.y, c.z);
    const auto L = random.array<6>(-0.5, 0.5);  // a positive covariance: rows of a square root
    const Sym3<double> cov{L[0] * L[0] + 0.1,  L[0] * L[1],        L[0] * L[2],
                           L[1] * L[1] + 0.05, L[1] * L[2] + 0.01, L[2] * L[2] + 0.2};
    const std::array<double, 9> x{mean[0], mean[1], mean[2], cov.xx, cov.xy,
                                  cov.xz,  cov.yy,  cov.yz,  cov.zz};
    const auto g = random.array<5>(-1, 1);
    auto expected = dual_gradient(x, [&](const auto& p) {
      Projection<Dual> out;
      const ViewArgs<Dual> view = test_view<Dual>();
      const Sym3<Dual> s{p[3], p[4], p[5], p[6], p[7], p[8]};
      EXPECT_TRUE(project_ewa(view, to_camera(view, Vec3<Dual>(p[0], p[1], p[2])), s,
                              kDilation<Dual>, out));
      return out.mean2d[0] * g[0] + out.mean2d[1] * g[1] + out.conic.xx * g[2] +
             Dual(2) * out.conic.xy * g[3] + out.conic.yy * g[4];
    });
    for (const size_t off_diagonal : {4u, 5u, 7u}) expected[off_diagonal] /= 2;
    const ViewArgs<double> view = test_view<double>();
    const Vec3<double> in_cam = to_camera(view, mean);
    Projection<double> out;
    ASSERT_TRUE(project_ewa(view, in_cam, cov, kDilation<double>, out));
    Vec3<double> d_mean(0.0);
    Sym3<double> d;
    project_ewa_backward(view, in_cam, cov, out.conic, Vec2<double>(g[0], g[1]),
                         Sym2<double>{g[2], g[3], g[4]}, d_mean, d);
    expect_near_all(std::array{d_mean[0], d_mean[1], d_mean[2], d.xx, d.xy, d.xz, d.yy, d.yz, d.zz},
                    expected, 1e-12, c.name);
  }
}

TEST(Ewa, ConicIsTheInverseOfTheCovariance) {
  const ViewArgs<double> view = test_view<double>();
  Projection<double> out;
  const Sym3<double> cov{0.3, 0.1, -0.05, 0.2, 0.02, 0.4};
  ASSERT_TRUE(project_ewa(view, Vec3<double>(0.4, -0.3, 2.5), cov, 0.3, out));
  EXPECT_NEAR(out.conic.xx * out.cov2d.xx + out.conic.xy * out.cov2d.xy, 1, 1e-13);
  EXPECT_NEAR(out.conic.xx * out.cov2d.xy + out.conic.xy * out.cov2d.yy, 0, 1e-13);
  EXPECT_NEAR(out.conic.xy * out.cov2d.xy + out.conic.yy * out.cov2d.yy, 1, 1e-13);
}

TEST(Ewa, ConicBackwardEqualsDuals) {
  Random random(2);
  const std::array<double, 3> cov{2.0, 0.7, 1.5};
  const auto g = random.array<3>(-1, 1);
  auto expected = dual_gradient(cov, [&](const auto& p) {
    const Dual inverse = Dual(1) / (p[0] * p[2] - p[1] * p[1]);
    return (p[2] * g[0] - Dual(2) * p[1] * g[1] + p[0] * g[2]) * inverse;
  });
  expected[1] /= 2;  // symmetric convention
  const double det = cov[0] * cov[2] - cov[1] * cov[1];
  const Sym2<double> d = conic_backward(Sym2<double>{cov[2] / det, -cov[1] / det, cov[0] / det},
                                        Sym2<double>{g[0], g[1], g[2]});
  expect_near_all(std::array{d.xx, d.xy, d.yy}, expected, 1e-12, "d_cov2d");
}

TEST(Ewa, DegenerateCovarianceIsRejected) {
  const ViewArgs<float> view = test_view<float>();
  Projection<float> out;
  const Vec3<float> in_cam(0.4f, -0.3f, 2.5f);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(project_ewa(view, in_cam, Sym3<float>{nan, 0, 0, 1, 0, 1}, 0.3f, out));
  EXPECT_FALSE(project_ewa(view, in_cam, Sym3<float>{}, 0.0f, out));
  EXPECT_TRUE(project_ewa(view, in_cam, Sym3<float>{}, 0.3f, out));
  EXPECT_NEAR(out.det, 0.09f, 1e-7f);
}

}  // namespace
}  // namespace tessera::testing
