// Demotion of dynamic Gaussians to static ones on every backend, against the template in double on
// the CPU. The equality of the image with that of the slice is tested in
// tests/recon4d/reduction/static_demotion_test.cpp.
#include <cmath>

#include "kernels/cpu_backend.h"
#include "kernels/load_gaussian.h"
#include "tests/support/backends.h"
#include "tests/support/stored_scene.h"

namespace tessera::testing {
namespace {

class BackendDemote : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendDemote);

constexpr int64_t kCount = 300;

/// Timesteps and opacities of the elements; every tenth has none.
struct Asked {
  std::vector<double> timestep, opacity;

  Asked() {
    Random random(5);
    for (int64_t n = 0; n < kCount; ++n) {
      timestep.push_back(random.uniform(0, 1));
      opacity.push_back(n % 10 == 3 ? 0 : random.uniform(0.01, 0.99));
    }
  }
};

template <class Real>
TestGaussians<Real> demoted(BackendOf<Real>& backend, const TestGaussians<Real>& set,
                            const RenderOptions& options, const Asked& asked) {
  Memory& memory = backend.memory();
  const StoredGaussians<Real> from(set, memory);
  StoredGaussians<Real> to(TestGaussians<Real>(SetForm::kStatic, set.count, set.coefficients),
                           memory);
  const auto brought = [&](const std::vector<double>& values) {
    return stored(std::vector<Real>(values.begin(), values.end()), memory);
  };
  const Buffer<Real> timestep = brought(asked.timestep), opacity = brought(asked.opacity);
  backend.demote({from.view(), options, timestep.span(), opacity.span(), to.spans()});
  return to.fetch();
}

template <class Real>
Sym3<double> covariance_of(const TestGaussians<Real>& set, int64_t n) {
  const Vec4<Real> q = load4(set.at(kRotation, n));
  const Vec3<Real> s = load3(set.at(kLogScale, n));
  return static_spacetime(Vec4<double>(q[0], q[1], q[2], q[3]), Vec3<double>(s[0], s[1], s[2]))
      .covariance;
}

// Bugs put back, each seen to fail on the CPU: the mean of the Gaussian; its own opacity; elements
// without opacity placed too.
TEST_P(BackendDemote, AsInDouble) {
  for (const SetForm form : {SetForm::kPair, SetForm::kVelocity})
    for (const int levels : {0, 2}) {
      SCOPED_TRACE(levels);
      TestScene<double> scene = random_scene(0, kCount, 0.15, 71, form);
      if (levels > 0) add_time_levels(scene.moving, levels, 72);
      scene.options.sh_degree = 2;
      scene.options.sh_time_degree = levels;
      const Asked asked;
      CpuBackend<double> oracle;
      const TestGaussians<double> expected = demoted(oracle, scene.moving, scene.options, asked);
      const TestGaussians<float> set = scene.moving.as<float>();
      const TestGaussians<float> found = demoted<float>(backend(), set, scene.options, asked);
      int64_t moved = 0;
      for (int64_t n = 0; n < kCount; ++n) {
        SCOPED_TRACE(n);
        for (int k = 0; k < 3; ++k)
          EXPECT_NEAR(double(found.at(kMean, n)[k]), expected.at(kMean, n)[k], 1e-4);
        EXPECT_NEAR(double(*found.at(kOpacityLogit, n)), *expected.at(kOpacityLogit, n), 1e-4);
        for (int k = 0; k < found.width(kSh); ++k)
          EXPECT_NEAR(double(found.at(kSh, n)[k]), expected.at(kSh, n)[k], 1e-4);
        const Sym3<double> a = covariance_of(found, n), b = covariance_of(expected, n);
        const double size = b.xx + b.yy + b.zz;
        for (const auto& [x, y] : {std::pair{a.xx, b.xx},
                                   {a.xy, b.xy},
                                   {a.xz, b.xz},
                                   {a.yy, b.yy},
                                   {a.yz, b.yz},
                                   {a.zz, b.zz}})
          EXPECT_NEAR(x, y, 1e-4 * size);
        if (asked.opacity[size_t(n)] > 0) {
          EXPECT_NEAR(sigmoid(double(*found.at(kOpacityLogit, n))), asked.opacity[size_t(n)], 1e-5);
          moved += std::abs(found.at(kMean, n)[0] - set.at(kMean, n)[0]) > 1e-3f;
          continue;
        }
        for (const Group group : {kMean, kLogScale, kRotation, kOpacityLogit, kSh})
          for (int k = 0; k < found.width(group); ++k)
            EXPECT_EQ(found.at(group, n)[k], set.at(group, n)[k]) << "as stored";
      }
      EXPECT_GT(moved, kCount / 2);
    }
}

}  // namespace
}  // namespace tessera::testing
