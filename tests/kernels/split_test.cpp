// The halves of a split Gaussian against their parent: places, shapes, opacity, and what lasts. The
// covariance on space-time is formed here from quaternion products. Source: kernels/edits/split.h.
#include "kernels/edits/split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/cpu_backend.h"
#include "kernels/math/pair_at_velocity.h"
#include "kernels/math/spacetime.h"
#include "tests/support/brute_force.h"
#include "tests/support/forms.h"
#include "tests/support/stored_scene.h"

namespace tessera::testing {
namespace {

/// Parents [0, N), then their first and their second children.
struct Halved {
  TestGaussians<double> parents, all;

  Halved(SetForm form, int64_t count, uint64_t seed) : parents(form, 0), all(form, 0) {
    Random random(seed);
    parents = random_gaussians(form, count, 1, 0.1, random);
    all = TestGaussians<double>(form, 3 * count);
    for (int g = 0; g < group_count(form); ++g)
      for (size_t i = 0; i < all.group[g].size(); ++i)
        all.group[g][i] = parents.group[g][i % parents.group[g].size()];
  }
  void split() {
    StoredGaussians<double> stored(all, host_memory());
    CpuBackend<double> backend;
    backend.place_children(stored.spans(), parents.count, {true, 0});
    all = stored.fetch();
  }
};

/// Σ₄ on (t, x, y, z): axes l·e_k·r of length scale_k; of a velocity, time's axis is σ_t (1, v).
std::array<std::array<double, 4>, 4> covariance(TestGaussians<double>& set, int64_t n) {
  const SetForm form = set.form;
  const Quaternion l = unit_quaternion(set.at(kRotation, n));
  const Quaternion r = form == SetForm::kPair ? unit_quaternion(set.at(kRotationRight, n))
                                              : Quaternion{l[0], -l[1], -l[2], -l[3]};
  std::array<std::array<double, 4>, 4> sigma{};
  for (size_t k = form == SetForm::kStatic ? 1 : 0; k < 4; ++k) {
    const double scale = std::exp(k == 0 ? *set.at(kLogScaleTime, n) : set.at(kLogScale, n)[k - 1]);
    Quaternion axis{};
    axis[k] = scale;
    Quaternion image = hamilton(hamilton(l, axis), r);
    for (size_t i = 0; form == SetForm::kVelocity && k == 0 && i < 3; ++i)
      image[i + 1] = scale * set.at(kVelocity, n)[i];
    for (size_t i = 0; i < 4; ++i)
      for (size_t j = 0; j < 4; ++j) sigma[i][j] += image[i] * image[j];
  }
  return sigma;
}

/// Σ_c: of space at one time.
Sym3<double> at_one_time(const std::array<std::array<double, 4>, 4>& s, bool moves) {
  const auto entry = [&](size_t i, size_t j) {
    return s[i][j] - (moves ? s[0][i] * s[0][j] / s[0][0] : 0);
  };
  return {entry(1, 1), entry(1, 2), entry(1, 3), entry(2, 2), entry(2, 3), entry(3, 3)};
}

double along(const Sym3<double>& s, const Vec3<double>& a, const Vec3<double>& b) {
  return dot(a, s * b);
}

class SplitHalves : public ::testing::TestWithParam<SetForm> {};
INSTANTIATE_TEST_SUITE_P(Form, SplitHalves, ::testing::ValuesIn(kForms),
                         [](const auto& form) { return form_name(form.param); });

constexpr int64_t kParents = 60;

// Bugs put back, seen to fail: both on one side; 0.7 in place of 0.8; the shortest axis; of a pair
// the axes of Σ₄ in place of those of Σ_c.
TEST_P(SplitHalves, KeepTheMeanAndTheVarianceAlongTheLongestAxis) {
  Halved halved(GetParam(), kParents, 5);
  halved.split();
  const bool moves = GetParam() != SetForm::kStatic;
  for (int64_t n = 0; n < kParents; ++n) {
    const Sym3<double> parent = at_one_time(covariance(halved.parents, n), moves);
    const Eigen3 axes = symmetric_eigen(parent);
    int longest = 0;
    for (int k = 1; k < 3; ++k)
      if (axes.values[k] > axes.values[longest]) longest = k;
    const Vec3<double> axis = axes.vectors[longest];
    const double deviation = std::sqrt(axes.values[longest]);
    double places = 0;
    for (const int64_t child : {kParents + n, 2 * kParents + n}) {
      const double *mean = halved.all.at(kMean, child), *old = halved.parents.at(kMean, n);
      const Vec3<double> offset(mean[0] - old[0], mean[1] - old[1], mean[2] - old[2]);
      const double place = dot(offset, axis) / deviation;
      EXPECT_NEAR(std::abs(place), 0.8, 1e-9);
      EXPECT_NEAR(dot(offset, offset), 0.64 * axes.values[longest], 1e-12);
      places += place;
      const Sym3<double> shape = at_one_time(covariance(halved.all, child), moves);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const double factor = (i == longest ? 0.6 : 0.9) * (j == longest ? 0.6 : 0.9);
          EXPECT_NEAR(along(shape, axes.vectors[i], axes.vectors[j]),
                      i == j ? factor * axes.values[i] : 0, 1e-11);
        }
      // of two equal halves the variance is that of one and the square of the distance
      EXPECT_NEAR(along(shape, axis, axis) + place * place * axes.values[longest],
                  axes.values[longest], 1e-11);
    }
    EXPECT_NEAR(places, 0, 1e-9) << "one on either side";
  }
}

// Bugs put back, seen to fail: the logit times 0.6; the temporal mean moved along the axis.
TEST_P(SplitHalves, AreFainterAndLastAsTheirParentDoes) {
  Halved halved(GetParam(), kParents, 6);
  halved.split();
  for (int64_t child = kParents; child < 3 * kParents; ++child) {
    const int64_t n = child % kParents;
    EXPECT_NEAR(sigmoid(*halved.all.at(kOpacityLogit, child)),
                0.6 * sigmoid(*halved.parents.at(kOpacityLogit, n)), 1e-12);
    for (int i = 0; i < halved.all.width(kSh); ++i)
      EXPECT_EQ(halved.all.at(kSh, child)[i], halved.parents.at(kSh, n)[i]);
    if (GetParam() == SetForm::kStatic) continue;
    EXPECT_EQ(*halved.all.at(kMeanTime, child), *halved.parents.at(kMeanTime, n));
    const auto now = covariance(halved.all, child), before = covariance(halved.parents, n);
    EXPECT_NEAR(now[0][0], before[0][0], 1e-11) << "the extent in time";
    for (size_t i = 1; i < 4; ++i) EXPECT_NEAR(now[0][i], before[0][i], 1e-11) << "the velocity";
  }
}

TEST_P(SplitHalves, ParentsBeforeTheFirstChildStay) {
  Halved halved(GetParam(), kParents, 7);
  halved.split();
  for (int g = 0; g < group_count(GetParam()); ++g)
    for (size_t i = 0; i < halved.parents.group[g].size(); ++i)
      EXPECT_EQ(halved.all.group[g][i], halved.parents.group[g][i]);
}

// Bug put back: the axes of time and x exchanged; seen to fail.
TEST(SplitHalf, OfAFastAndThinPairKeepTheirDigits) {
  TestGaussians<double> set(SetForm::kPair, 3);
  const MovingPair fast = pair_at_velocity(1e-3, 0.05, {40, -25, 10});
  for (int64_t n = 0; n < 3; ++n) {
    for (int k = 0; k < 4; ++k) {
      set.at(kRotation, n)[k] = fast.left[k];
      set.at(kRotationRight, n)[k] = fast.right[k];
    }
    for (int k = 0; k < 3; ++k) set.at(kLogScale, n)[k] = fast.log_scale[k];
    *set.at(kLogScaleTime, n) = fast.log_scale_time;
  }
  StoredGaussians<double> stored(set, host_memory());
  CpuBackend<double>().place_children(stored.spans(), 1, {true, 0});
  set = stored.fetch();
  for (const int64_t n : {1, 2}) {
    const Spacetime<double> s =
        pair_spacetime(load4(set.at(kRotation, n)), load4(set.at(kRotationRight, n)),
                       load3(set.at(kLogScale, n)), *set.at(kLogScaleTime, n), 0.0);
    EXPECT_NEAR(s.velocity[0], 40, 1e-6);
    EXPECT_NEAR(s.velocity[1], -25, 1e-6);
    EXPECT_NEAR(1 / std::sqrt(s.precision_time), 0.05, 1e-9);
    const Eigen3 axes = symmetric_eigen(s.covariance);
    double least = 1, most = 0;
    for (int k = 0; k < 3; ++k) {
      least = std::min(least, axes.values[k]);
      most = std::max(most, axes.values[k]);
    }
    EXPECT_NEAR(std::sqrt(least), 0.6e-3, 1e-8);
    EXPECT_NEAR(std::sqrt(most), 0.9e-3, 1e-8);
  }
}

}  // namespace
}  // namespace tessera::testing
