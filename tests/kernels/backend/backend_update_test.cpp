// The optimizer of every backend: fused and separate, dense and skipping, against each other and
// against the oracle.
#include "tests/support/backends.h"
#include "tests/support/compare.h"
#include "tests/support/optimised.h"

namespace tessera::testing {
namespace {

constexpr int64_t kFirstStep = 101;
constexpr int kHidden = 5;  // of each set, the first ones: too transparent to be drawn

/// Gaussians of both sets, some of them idle.
TestScene<double> scene_with_idle(uint64_t seed) {
  TestScene<double> scene = random_scene(60, 60, 0.2, seed);
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (int64_t n = 0; n < kHidden; ++n) *set->at(kOpacityLogit, n) = -8;
  keep_truth_away(scene, seed + 1);
  // gradients in a fixed order: what differs then is the optimizer
  scene.options.kernels.deterministic = true;
  return scene;
}

struct Trained {
  std::vector<TestGaussians<double>> value, moment1, moment2;
};

template <class Real>
Trained train(const TestScene<double>& scene, BackendOf<Real>& backend, bool fused, IdleUpdate idle,
              int steps) {
  Memory& memory = backend.memory();
  const TestScene<Real> start = scene.as<Real>();
  const StoredScene<Real> in(start, memory);
  Optimised<Real> state(start, memory);
  Pipeline<Real> pipeline(backend);
  for (int64_t step = kFirstStep; step < kFirstStep + steps; ++step) {
    ForwardArgs<Real> forward = in.forward(true);
    BackwardArgs<Real> args;
    for (size_t set = 0; set < 2; ++set) {
      forward.sets[set] = std::as_const(state.value[set]).view();
      args.sinks[set] = state.sink(set, step, fused, idle);
    }
    pipeline.forward(forward);
    pipeline.loss(in.target(), true);
    pipeline.backward(args);
    for (size_t set = 0; set < 2 && !fused; ++set) backend.adam(args.sinks[set]);
    EXPECT_EQ(pipeline.outcome().bad_groups, 0u);
  }
  Trained out;
  for (size_t set = 0; set < 2; ++set) {
    out.value.push_back(state.value[set].fetch().template as<double>());
    out.moment1.push_back(state.fetch_moments(set, 1).template as<double>());
    out.moment2.push_back(state.fetch_moments(set, 2).template as<double>());
  }
  return out;
}

/// Steps and moments of both sets within the bounds.
void expect_trained(const Trained& actual, const Trained& expected, const TestScene<double>& start,
                    const GroupBounds& bounds, double packed = 0) {
  const TestScene<double> rounded = start.as<float>().as<double>();
  for (size_t set = 0; set < 2; ++set) {
    const TestGaussians<double>& before = set == 0 ? rounded.fixed : rounded.moving;
    for (int g = 0; g < group_count(before.form); ++g) {
      const std::string name = group_name(Group(g), before.form);
      // packed moments are rounded to 2^-7 of themselves, up as often as down
      GroupBounds rounded_bounds = bounds;
      if (packs_moments(Group(g))) rounded_bounds.element = std::max(bounds.element, packed);
      expect_group(change(actual.value[set].group[g], before.group[g]),
                   change(expected.value[set].group[g], before.group[g]), rounded_bounds, name);
      expect_group(actual.moment1[set].group[g], expected.moment1[set].group[g], rounded_bounds,
                   name + " moment1");
      expect_group(actual.moment2[set].group[g], expected.moment2[set].group[g], rounded_bounds,
                   name + " moment2");
    }
  }
}

class BackendUpdate : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendUpdate);

TEST_P(BackendUpdate, FusedAdamEqualsTheSeparateOne) {
  // Bug put back: the rate of the other bands for coefficient 0, in one of both; seen to fail.
  const TestScene<double> scene = scene_with_idle(41);
  const Trained fused = train(scene, backend(), true, IdleUpdate::kDense, 3);
  const Trained separate = train(scene, backend(), false, IdleUpdate::kDense, 3);
  // values of order 1 are rounded to 1e-7 at each step, steps are of order 1e-3
  expect_trained(fused, separate, scene, {5e-4, 5e-4, 0, 1e-4});
}

TEST_P(BackendUpdate, FusedAdamEqualsTheOracles) {
  const TestScene<double> scene = scene_with_idle(43);
  CpuBackend<double> oracle;
  // gradients in float, see kGradientBounds, enter with a tenth of the moment's size
  for (const bool fused : {true, false})
    expect_trained(train(scene, backend(), fused, IdleUpdate::kDense, 2),
                   train(scene.as<float>().as<double>(), oracle, true, IdleUpdate::kDense, 2),
                   scene, {1e-3, 2e-2, 0.005, 5e-4}, 1.0 / 128);
}

TEST_P(BackendUpdate, DenseMovesIdleGaussiansByTheirMoments) {
  // Bug put back: idle Gaussians skipped; seen to fail.
  const TestScene<double> scene = scene_with_idle(45);
  const TestScene<float> rough = scene.as<float>();
  const Trained after = train(scene, backend(), true, IdleUpdate::kDense, 1);
  const auto moment1 = Optimised<float>::moments(rough.moving, 1);
  const auto moment2 = Optimised<float>::moments(rough.moving, 2);
  for (int g = 0; g < kGroupCount; ++g)
    for (int64_t i = 0; i < kHidden * group_width(Group(g), 16, SetForm::kPair); ++i) {
      float x = rough.moving.group[g][size_t(i)], m = moment1.group[g][size_t(i)],
            v = moment2.group[g][size_t(i)];
      const double rate = g == kSh && i % 48 >= 3 ? 1e-4 : 1e-3 * (g + 1);
      adam_step(adam_scalars<float>(rate, kFirstStep), 0.0f, x, m, v);
      EXPECT_NEAR(after.value[1].group[g][size_t(i)], x, 2e-6)
          << group_name(Group(g), SetForm::kPair);
      const double rounding = packs_moments(Group(g)) ? 1.0 / 128 : 0;
      EXPECT_NEAR(after.moment1[1].group[g][size_t(i)], m, 1e-9 + rounding * std::abs(m))
          << group_name(Group(g), SetForm::kPair);
      EXPECT_NEAR(after.moment2[1].group[g][size_t(i)], v, 1e-12 + rounding * v)
          << group_name(Group(g), SetForm::kPair);
    }
}

TEST_P(BackendUpdate, SkipLeavesIdleGaussiansUntouched) {
  // Bug put back: skipping does nothing; seen to fail.
  const TestScene<double> scene = scene_with_idle(47);
  const TestScene<double> rounded = scene.as<float>().as<double>();
  const Trained skip = train(scene, backend(), true, IdleUpdate::kSkip, 2);
  const Trained dense = train(scene, backend(), true, IdleUpdate::kDense, 2);
  for (size_t set = 0; set < 2; ++set) {
    const TestGaussians<double>& before = set == 0 ? rounded.fixed : rounded.moving;
    const TestGaussians<float> rough = before.as<float>();
    const auto moment1 = Optimised<float>::moments(rough, 1).as<double>();
    const auto moment2 = Optimised<float>::moments(rough, 2).as<double>();
    for (int g = 0; g < group_count(before.form); ++g) {
      const size_t idle = size_t(kHidden * group_width(Group(g), 16, before.form));
      for (size_t i = 0; i < idle; ++i) {
        ASSERT_EQ(skip.value[set].group[g][i], before.group[g][i]);
        ASSERT_EQ(skip.moment1[set].group[g][i], moment1.group[g][i]);
        ASSERT_EQ(skip.moment2[set].group[g][i], moment2.group[g][i]);
        ASSERT_NE(dense.value[set].group[g][i], before.group[g][i]);
      }
    }
  }
}

TEST_P(BackendUpdate, SkipUpdatesTheOthersAsDenseDoes) {
  TestScene<double> scene = scene_with_idle(49);
  const Backward<double> seen = backward(scene);
  const Trained skip = train(scene, backend(), true, IdleUpdate::kSkip, 1);
  const Trained dense = train(scene, backend(), true, IdleUpdate::kDense, 1);
  int compared = 0;
  for (size_t set = 0; set < 2; ++set) {
    const TestGaussians<double>&a = skip.value[set], &e = dense.value[set];
    for (int64_t n = kHidden; n < a.count; ++n) {
      if (seen.seen[set][size_t(n)] == 0) continue;
      ++compared;
      for (int g = 0; g < group_count(a.form); ++g)
        for (int i = 0; i < group_width(Group(g), 16, a.form); ++i)
          ASSERT_NEAR(a.at(Group(g), n)[i], e.at(Group(g), n)[i], 1e-6)
              << group_name(Group(g), SetForm::kPair);
    }
  }
  EXPECT_GT(compared, 60);
}

}  // namespace
}  // namespace tessera::testing
