// Replacement of one Gaussian by n: opacity and size against the double sum of the source, against
// the integral it is derived from, and in images; the choice and frequency of the drawn Gaussians.
// Rows of a training are tested in tests/recon4d/density/train_mcmc_test.cpp.
#include "kernels/edits/mcmc.h"

#include "tests/support/render.h"

namespace tessera::testing {
namespace {

double binomial(int n, int k) {
  double value = 1;
  for (int j = 1; j <= k; ++j) value = value * double(n - k + j) / j;
  return value;
}

/// f as the source writes it: two sums.
double direct_scale(double opacity, double each, int n) {
  long double sum = 0;
  for (int i = 1; i <= n; ++i)
    for (int k = 0; k < i; ++k)
      sum += (k % 2 == 0 ? 1.0L : -1.0L) * (long double)(binomial(i - 1, k)) *
             std::pow((long double)(each), k + 1) / std::sqrt((long double)(k + 1));
  return double((long double)(opacity) / sum);
}

TEST(Relocation, EqualsTheDoubleSumOfTheSource) {
  // Bug put back: the sum in float; seen to fail.
  for (const double o : {1e-4, 0.006, 0.1, 0.6, 0.9, 0.999, 1 - 0x1p-23})
    for (int n = 1; n <= kMostCopies; ++n) {
      const Relocated r = relocated(o, n);
      EXPECT_NEAR(std::pow(1 - r.opacity, n), 1 - o, 1e-15 * n) << o << " " << n;
      EXPECT_NEAR(r.scale, direct_scale(o, r.opacity, n), 1e-9) << o << " " << n;
    }
  EXPECT_NEAR(relocated(0.6, 2).opacity, 0.36754, 5e-6);
  EXPECT_NEAR(relocated(0.6, 2).scale, 0.93814, 5e-6);
  EXPECT_NEAR(relocated(0.6, 10).opacity, 0.08756, 5e-6);
  EXPECT_NEAR(relocated(0.6, 10).scale, 0.89219, 5e-6);
  EXPECT_NEAR(relocated(0.6, 1).opacity, 0.6, 1e-15);
  EXPECT_NEAR(relocated(0.6, 1).scale, 1, 1e-15);
  EXPECT_EQ(relocated(0.6, 51).scale, relocated(0.6, 50).scale) << "counted as 50";
  EXPECT_LT(relocated(1, 50).opacity, 0.3) << "an opaque one, too";
}

TEST(Relocation, KeepsTheIntegralThroughTheCentre) {
  // ∫ 1 − (1 − o' e^{−x²/2f²})^n dx = o √(2π): what f is made for. Bug put back: √k left out of
  // the sum; seen to fail.
  for (const double o : {0.05, 0.6, 0.95})
    for (const int n : {1, 2, 7, 50}) {
      const Relocated r = relocated(o, n);
      double sum = 0;
      constexpr double kStep = 1e-2;
      for (double x = -10; x <= 10; x += kStep)
        sum +=
            kStep * (1 - std::pow(1 - r.opacity * std::exp(-x * x / (2 * r.scale * r.scale)), n));
      EXPECT_NEAR(sum, o * std::sqrt(2 * 3.14159265358979324), 1e-9) << o << " " << n;
    }
}

/// A Gaussian of a set in the middle of an image of 33 × 33 pixels, whose centre pixel it hits.
TestScene<double> single(const TestGaussians<double>& set, double time) {
  TestScene<double> scene;
  (set.form == SetForm::kStatic ? scene.fixed : scene.moving) = set;
  Camera camera = look_at({0, 0, -4}, {0, 0, 0}, 33, 33, 40);
  camera.cx = camera.cy = 16.5;
  scene.views = {{camera, time}};
  return scene;
}

TestGaussians<double> one_gaussian(SetForm form, double opacity) {
  Random random(5);
  TestGaussians<double> set = random_gaussians(form, 1, 0, 0.3, random);
  *set.at(kOpacityLogit, 0) = std::log(opacity / (1 - opacity));
  return set;
}

TestGaussians<double> copies_of(TestGaussians<double> set, int n) {
  with_form(set.form, [&](auto form) { become_copies<form()>(set.spans(), 0, n, 0.005); });
  return set.select(std::vector<int64_t>(size_t(n), 0));
}

TEST(Relocation, CopiesLookAsTheOneDid) {
  // Bugs put back, each seen to fail: o' = o/n; the size left as it was.
  for (const SetForm form : kForms)
    for (const double o : {0.3, 0.6, 0.9})
      for (const int n : {2, 3, 10}) {
        SCOPED_TRACE(std::string(form_name(form)) + " " + std::to_string(o) + " " +
                     std::to_string(n));
        const TestGaussians<double> one = one_gaussian(form, o);
        const double time = form != SetForm::kStatic ? *one.at(kMeanTime, 0) : 0;
        const std::vector<double> T = render(single(one, time)).transmittance;
        const std::vector<double> many = render(single(copies_of(one, n), time)).transmittance;
        const size_t centre = 33 * 16 + 16;
        EXPECT_NEAR(many[centre], T[centre], 1e-6);
        // beside the centre 1 − (1 − o'G^{1/f²})^n is not oG, and each copy is cut off below 1/255
        const Relocated r = relocated(o, n);
        double known = 0, worst = 0;
        for (double x = 0; x < 4; x += 0.01) {
          const double thin = std::exp(-x * x / (2 * r.scale * r.scale));
          const double alpha = 1 - std::pow(1 - r.opacity * thin, n);
          known = std::max(known, std::abs(alpha - o * std::exp(-x * x / 2)));
        }
        for (size_t p = 0; p < T.size(); ++p) worst = std::max(worst, std::abs(T[p] - many[p]));
        EXPECT_LE(worst, known + n / 255.0);
      }
}

TEST(Relocation, ADynamicOneKeepsItsVelocityAndItsLifeInSum) {
  // Bug put back: the scale in time left as it was; seen to fail.
  for (const uint64_t seed : {1, 2, 3}) {
    Random random(seed);
    TestGaussians<double> set = random_gaussians(SetForm::kPair, 1, 0, 0.3, random);
    *set.at(kOpacityLogit, 0) = 1;
    GaussianState<double> before, after;
    ASSERT_TRUE(load_gaussian<SetForm::kPair>(set.view(), 0, before));
    become_copies<SetForm::kPair>(set.spans(), 0, 3, 0.005);
    ASSERT_TRUE(load_gaussian<SetForm::kPair>(std::as_const(set).view(), 0, after));
    const double f = relocated(before.opacity, 3).scale;
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(after.spacetime.velocity[k], before.spacetime.velocity[k], 1e-12);
    EXPECT_NEAR(after.spacetime.covariance.xy, f * f * before.spacetime.covariance.xy, 1e-12);
    EXPECT_NEAR(after.spacetime.precision_time * f * f, before.spacetime.precision_time, 1e-12);
    // so that the integral over time of what the centre hides is the same, too
    const auto hidden = [](const GaussianState<double>& g, int n) {
      double sum = 0;
      for (double t = -5; t < 5; t += 1e-3)
        sum +=
            1e-3 *
            (1 - std::pow(1 - g.opacity *
                                  slice_at(g.mean, g.spacetime, g.spacetime.mean_time + t).marginal,
                          n));
      return sum;
    };
    EXPECT_NEAR(hidden(after, 3), hidden(before, 1), 1e-9);
  }
}

RelocationElements relocate(TestGaussians<double>& set, const RelocationRule& rule) {
  RelocationElements rows;
  CpuBackend<double>().relocate_elements(set.spans(), rule, rows);
  return rows;
}

TEST(Relocation, SourcesAreDrawnByOpacity) {
  // χ² of 40 classes: 39 ± 5·√78. Bugs put back, each seen to fail: all weights equal; the weight
  // of a neighbour.
  constexpr int64_t kCount = 40, kDraws = 40000;
  Random random(11);
  TestGaussians<double> set = random_gaussians(SetForm::kStatic, kCount, 1, 0.1, random);
  double sum = 0;
  std::vector<double> opacity;
  for (int64_t n = 0; n < kCount; ++n) opacity.push_back(sigmoid(*set.at(kOpacityLogit, n)));
  for (const double o : opacity) sum += o;
  const RelocationElements rows = relocate(set, {-1, 0.005, kDraws, 3});
  std::vector<double> drawn(kCount, 0);
  for (int64_t i = kCount; i < kCount + kDraws; ++i) ++drawn[size_t(rows.values[i])];
  double chi2 = 0;
  for (size_t n = 0; n < drawn.size(); ++n) {
    const double expected = kDraws * opacity[n] / sum;
    chi2 += (drawn[n] - expected) * (drawn[n] - expected) / expected;
  }
  EXPECT_LT(chi2, 39 + 5 * std::sqrt(78.0));
  EXPECT_GT(chi2, 39 - 5 * std::sqrt(78.0) * 0.7) << "too even to be drawn";
}

TEST(Relocation, UniformBelowIsTheHighHalfOfAProduct) {
  // Bug put back: the carry of the low halves dropped; seen to fail.
  Random random(12);
  for (int i = 0; i < 1000; ++i) {
    const auto word = [&] { return uint32_t(random.uniform(0, 4294967296.0)); };
    const RandomBlock block{{i % 7 == 0 ? ~0u : word(), i % 5 == 0 ? ~0u : word(), 0, 0}};
    const uint64_t count = i % 3 == 0 ? ~uint64_t{0} - uint64_t(i) : uint64_t(word()) << (i % 32);
    const uint64_t bits = uint64_t(block.word[0]) << 32 | block.word[1];
    __extension__ using Wide = unsigned __int128;
    EXPECT_EQ(uniform_below(block, count), uint64_t(Wide(bits) * count >> 64));
  }
}

TEST(Relocation, OnlyDeadGaussiansMoveAndOnlyToLivingOnes) {
  // Failure mode C13: as many as were dead. Bugs put back, each seen to fail: ≥ in place of > in
  // the test for living Gaussians; a quaternion of length 0 counts as living.
  TestGaussians<double> set(SetForm::kStatic, 300);
  for (int64_t n = 0; n < set.count; ++n) {
    *set.at(kRotation, n) = n % 10 == 7 ? 0 : 1;
    *set.at(kOpacityLogit, n) = n % 3 == 0 ? 1000 : n % 3 == 1 ? 2 : -6;
  }
  const TestGaussians<double> before = set;
  *set.at(kOpacityLogit, 2) = std::nan("");
  const double limit = sigmoid(-6.0);  // exactly at the limit is dead
  const RelocationElements rows = relocate(set, {limit, 0.005, 0, 9});
  int64_t dead = 0;
  std::vector<int> copies(300, 1);
  for (int64_t n = 0; n < 300; ++n) {
    const bool is_dead = n % 3 == 2 || n % 10 == 7;
    dead += is_dead;
    EXPECT_EQ(rows.values[n] != n, is_dead) << n;
    const int64_t source = rows.values[n];
    EXPECT_TRUE(source % 3 != 2 && source % 10 != 7) << source;
    if (!is_dead) continue;
    ++copies[size_t(source)];
    EXPECT_EQ(rows.moments[n], n) << "keeps its own";
  }
  EXPECT_EQ(rows.moved, dead);
  for (int64_t n = 0; n < 300; ++n) {
    const bool was_drawn = copies[size_t(n)] > 1;
    EXPECT_EQ(rows.moments[n], was_drawn ? -1 : n);
    if (n == 2) continue;
    EXPECT_EQ(*set.at(kOpacityLogit, n) != *before.at(kOpacityLogit, n), was_drawn) << n;
    if (!was_drawn) continue;
    const double o = sigmoid(*set.at(kOpacityLogit, n));
    EXPECT_TRUE(o >= 0.005 - 1e-12 && o <= kMostRelocatedOpacity) << o;
  }
}

TEST(Relocation, NoGaussianIsMovedWhereAllAreDead) {
  for (const int64_t count : {0, 1, 5}) {
    TestGaussians<double> set(SetForm::kPair, count);
    std::fill(set.group[kOpacityLogit].begin(), set.group[kOpacityLogit].end(), -9.0);
    const RelocationElements rows = relocate(set, {0.005, 0.005, 0, 1});
    EXPECT_EQ(rows.moved + rows.weight, 0);
    ASSERT_EQ(rows.values.size(), count);
    for (int64_t n = 0; n < count; ++n) EXPECT_EQ(rows.values[n] + rows.moments[n], 2 * n);
    EXPECT_THROW(relocate(set, {0.005, 0.005, 3, 1}), std::logic_error);
  }
}

}  // namespace
}  // namespace tessera::testing
