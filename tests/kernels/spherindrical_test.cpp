// The levels of time-varying colours: weights and slopes against the cosine, laws of the whole
// chain (levels of zeros, inactive levels, another clock), and the Gaussians that may use a level.
// Images and gradients are tested in brute_force_test.cpp and gradient_test.cpp.
#include "kernels/math/spherindrical.h"

#include "tests/support/compare.h"
#include "tests/support/render.h"

namespace tessera::testing {
namespace {

TEST(Turns, AreSineAndCosineHoweverManyThereAre) {
  // Bug put back: whole turns not taken off; seen to fail in float.
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const double x = random.uniform(-1, 1), whole = random.below(1000) - 500;
    EXPECT_NEAR(cos_turns(x), std::cos(2 * M_PI * x), 1e-15);
    EXPECT_NEAR(sin_turns(x), std::sin(2 * M_PI * x), 1e-15);
    const float many = float(x + whole);
    EXPECT_NEAR(cos_turns(many), std::cos(2 * M_PI * std::remainder(double(many), 1.0)), 4e-7);
    EXPECT_NEAR(sin_turns(many), std::sin(2 * M_PI * std::remainder(double(many), 1.0)), 4e-7);
  }
}

TEST(Levels, AreTheCosineSeriesAndItsSlopeInTheMeanTime) {
  // Bugs put back, each seen to fail: n left out of the slope; its sign turned; the period ignored.
  Random random(2);
  for (const double period : {1.0, 0.37}) {
    const ColourRules<double> rules{3, 2, 48, period, true};
    const auto time = random.array<96>(-1, 1);
    const auto d = random.array<3>(-1, 1);
    const Vec3<double> direction = glm::normalize(Vec3<double>(0.3, -0.8, 0.4));
    const Vec3<double> d_colour(d[0], d[1], d[2]);
    const auto along = [&](double mean_time) {  // ⟨d_colour, colour⟩ at t = 0.2
      double sh[48] = {};
      add_levels(rules, 0.2 - mean_time, time.data(), sh);
      return dot(sh_colour(3, direction, sh), d_colour);
    };
    for (const double mean_time : {-0.4, 0.2, 0.93}) {
      double sh[48] = {};
      add_levels(rules, 0.2 - mean_time, time.data(), sh);
      for (size_t j = 0; j < 48; ++j)
        EXPECT_NEAR(sh[j],
                    std::cos(2 * M_PI * (0.2 - mean_time) / period) * time[j] +
                        std::cos(4 * M_PI * (0.2 - mean_time) / period) * time[48 + j],
                    1e-13);
      constexpr double h = 1e-5;
      EXPECT_NEAR(dot(levels_slope(rules, 0.2 - mean_time, time.data(), direction), d_colour),
                  (along(mean_time + h) - along(mean_time - h)) / (2 * h), 1e-7);
    }
  }
}

TestScene<double> levelled_scene(SetForm form, int levels, uint64_t seed) {
  TestScene<double> scene = random_scene(12, 25, 0.2, seed, form);
  add_time_levels(scene.moving, levels, seed + 1);
  return scene;
}

template <class Real>
void expect_same(const Backward<Real>& a, const Backward<Real>& b) {
  EXPECT_EQ(a.rendered.colour, b.rendered.colour);
  for (int g = 0; g < kShTime; ++g) EXPECT_EQ(a.moving.group[g], b.moving.group[g]);
  EXPECT_EQ(a.fixed.group[kMean], b.fixed.group[kMean]);
}

// Bug put back: levels evaluated beyond sh_time_degree; seen to fail.
TEST(Levels, OfZerosOrNotActiveAreAsNone) {
  for (const SetForm form : kDynamicForms) {
    TestScene<float> scene = levelled_scene(form, 2, 11).as<float>(), none = scene;
    none.moving.time_levels = 0;
    none.moving.group[kShTime].clear();
    const Backward<float> expected = backward(none);
    EXPECT_NE(backward(scene).rendered.colour, expected.rendered.colour);
    scene.options.sh_time_degree = 0;
    const Backward<float> inactive = backward(scene);
    expect_same(inactive, expected);
    for (const float g : inactive.moving.group[kShTime]) ASSERT_EQ(g, 0.0f);
    scene.options.sh_time_degree = 2;
    for (float& c : scene.moving.group[kShTime]) c = 0;
    expect_same(backward(scene), expected);
  }
}

// The second level alone is inactive: as if only the first were stored. Bug put back: all that are
// stored; seen to fail.
TEST(Levels, AreActiveOneByOne) {
  TestScene<float> both = levelled_scene(SetForm::kPair, 2, 13).as<float>(), one = both;
  one.moving.time_levels = 1;
  one.moving.group[kShTime].clear();
  for (int64_t n = 0; n < both.moving.count; ++n)
    one.moving.group[kShTime].insert(one.moving.group[kShTime].end(), both.moving.at(kShTime, n),
                                     both.moving.at(kShTime, n) + 48);
  both.options.sh_time_degree = 1;
  const Backward<float> a = backward(both), b = backward(one);
  expect_same(a, b);
  for (int64_t n = 0; n < both.moving.count; ++n)
    for (int j = 0; j < 96; ++j)
      ASSERT_EQ(a.moving.at(kShTime, n)[j], j < 48 ? b.moving.at(kShTime, n)[j] : 0.0f);
}

// A clock that runs a times as fast and starts elsewhere shows the same, with T as with all times.
// Bug put back: the period ignored; seen to fail.
TEST(Levels, AnotherClockShowsTheSame) {
  constexpr double a = 2.5, b = -0.7;
  TestScene<double> scene = levelled_scene(SetForm::kVelocity, 2, 17), other = scene;
  for (double& t : other.moving.group[kMeanTime]) t = a * t + b;
  for (double& s : other.moving.group[kLogScaleTime]) s += std::log(a);
  for (double& v : other.moving.group[kVelocity]) v /= a;
  for (View& view : other.views) view.time = a * view.time + b;
  other.options.sh_time_period = a * scene.options.sh_time_period;
  const Backward<double> usual = backward(scene), rescaled = backward(other);
  EXPECT_LE(relative(rescaled.rendered.colour, usual.rendered.colour), 1e-12);
  EXPECT_LE(relative(rescaled.moving.group[kShTime], usual.moving.group[kShTime]), 1e-10);
}

TEST(Levels, ThatAreNotFiniteAreNotDrawnNorLearned) {  // C5
  // Bugs put back, each seen to fail: the levels' bit not set; levels left out of the colour.
  TestScene<float> scene = levelled_scene(SetForm::kPair, 1, 19).as<float>();
  scene.moving.at(kShTime, 4)[0] = std::numeric_limits<float>::quiet_NaN();
  const Backward<float> spoilt = backward(scene);
  EXPECT_EQ(spoilt.rendered.report.invalid_gaussians, 1);
  EXPECT_EQ(spoilt.bad, 0u);
  for (const float c : spoilt.rendered.colour) ASSERT_TRUE(std::isfinite(c));
  scene = levelled_scene(SetForm::kPair, 1, 19).as<float>();
  const auto poisoned = backward<float>(scene, [](std::vector<float>& d) {
    for (float& x : d) x = std::numeric_limits<float>::quiet_NaN();
  });
  EXPECT_EQ(poisoned.bad, (1u << kDynamicGroups) - 1);
}

}  // namespace
}  // namespace tessera::testing
