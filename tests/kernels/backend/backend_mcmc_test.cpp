// Relocation, noise and regularisers of every backend against those of the CPU, which are tested in
// relocation_test.cpp, position_noise_test.cpp and regulariser_test.cpp.
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/crowd.h"
#include "tests/support/optimised.h"

namespace tessera::testing {
namespace {

class BackendMcmc : public BesideCpu {};
TESSERA_ON_EVERY_BACKEND(BackendMcmc);

struct Relocated {
  std::vector<int64_t> values, moments;
  int64_t moved, weight;
  TestGaussians<float> set;
};

Relocated relocate(Backend& on, const TestGaussians<float>& set, const RelocationRule& rule) {
  StoredGaussians<float> gaussians(set, on.memory());
  RelocationElements elements(on.memory());
  on.relocate_elements(gaussians.spans(), rule, elements);
  return {fetched(elements.values, on.memory()), fetched(elements.moments, on.memory()),
          elements.moved, elements.weight, gaussians.fetch()};
}

TEST_P(BackendMcmc, RelocationIsTheCpus) {
  // Weights are whole numbers of opacities in double: draws are equal, not alike.
  for (const SetForm form : kForms)
    for (const double dead : {-1.0, 0.005, 0.5})
      for (const int64_t added : {int64_t{0}, int64_t{777}, 3 * kCrowd}) {
        SCOPED_TRACE(std::string(form_name(form)) + " dead " + std::to_string(dead) + " added " +
                     std::to_string(added));
        const TestGaussians<float> set = crowd(form, 91);
        const RelocationRule rule{dead, 0.005, added, 92};
        const Relocated actual = relocate(backend(), set, rule);
        const Relocated expected = relocate(cpu(), set, rule);
        EXPECT_EQ(actual.values, expected.values);
        EXPECT_EQ(actual.moments, expected.moments);
        EXPECT_EQ(actual.moved, expected.moved);
        EXPECT_EQ(actual.weight, expected.weight);
        for (int g = 0; g < group_count(form); ++g)
          for (size_t i = 0; i < set.group[g].size(); ++i)  // from logarithms in double
            ASSERT_NEAR(actual.set.group[g][i], expected.set.group[g][i],
                        2e-7 * std::max(1.0f, std::abs(expected.set.group[g][i])))
                << group_name(Group(g), form) << " " << i;
      }
}

TEST_P(BackendMcmc, RelocationOfEmptyAndOfDyingSets) {
  for (const int64_t count : {0, 1, 70}) {
    TestGaussians<float> set = crowd(SetForm::kPair, 93, count);
    std::fill(set.group[kOpacityLogit].begin(), set.group[kOpacityLogit].end(), -9.0f);
    const Relocated none = relocate(backend(), set, {0.005, 0.005, 0, 94});
    EXPECT_EQ(none.moved + none.weight, 0);
    EXPECT_EQ(none.values, relocate(cpu(), set, {0.005, 0.005, 0, 94}).values);
    EXPECT_EQ(none.set.group[kOpacityLogit], set.group[kOpacityLogit]);
    EXPECT_THROW(relocate(backend(), set, {0.005, 0.005, 1, 94}), std::logic_error);
  }
}

TEST_P(BackendMcmc, NoiseIsTheCpus) {
  for (const SetForm form : kForms) {
    const TestGaussians<float> before = crowd(form, 95);
    const auto moved = [&](Backend& on) {
      StoredGaussians<float> set(before, on.memory());
      on.add_position_noise(set.spans(), {20, 7, 123456});
      return set.fetch();
    };
    const TestGaussians<float> actual = moved(backend()), expected = moved(cpu());
    int64_t still = 0;
    for (size_t i = 0; i < before.group[kMean].size(); ++i) {
      // steps of up to 2 from logarithms, sines and exponentials that are good to 1e-6
      ASSERT_NEAR(actual.group[kMean][i], expected.group[kMean][i], 1e-5);
      still += actual.group[kMean][i] == before.group[kMean][i];
    }
    EXPECT_GT(still, kCrowd);  // the opaque ones
    EXPECT_LT(still, 2 * 3 * kCrowd / 3);
    for (int g = 1; g < group_count(form); ++g) EXPECT_EQ(actual.group[g], before.group[g]);
  }
  backend().add_position_noise(GaussianSpans<float>{}, {1, 1, 1});
}

TEST_P(BackendMcmc, RegularisedGradientsAreTheOracles) {
  // Bugs put back: static Gaussians that no view draws too; dynamic ones by their views alone; each
  // seen to fail.
  TestScene<double> scene = random_scene(90, 110, 0.15, 97);
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (int64_t n = 0; n < 20; ++n) set->at(kMean, n)[1] = 500;
  keep_truth_away(scene, 98);
  scene.regulariser = {0.5, 0.8};
  const TestScene<float> rough = scene.as<float>();
  const Backward<float> actual = backward(rough, backend());
  const Backward<double> expected = backward(rough.as<double>());
  EXPECT_EQ(actual.bad, 0u);
  for (const Group group : {kOpacityLogit, kLogScale}) {
    expect_group(actual.fixed.group[group], expected.fixed.group[group], kGradientBounds, "static");
    expect_group(actual.moving.group[group], expected.moving.group[group], kGradientBounds,
                 "dynamic");
  }
  for (int64_t n = 0; n < 20; ++n) {
    EXPECT_EQ(*actual.fixed.at(kOpacityLogit, n), 0) << "out of sight";
    EXPECT_GT(*actual.moving.at(kOpacityLogit, n), 0) << "out of sight, but dynamic";
  }
}

TEST_P(BackendMcmc, RegularisersReachTheFusedOptimizer) {
  TestScene<double> scene = random_scene(30, 30, 0.2, 99);
  scene.options.kernels.deterministic = true;
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (int64_t n = 0; n < 10; ++n) set->at(kMean, n)[1] = 500;
  const TestScene<float> rough = scene.as<float>();
  std::vector<TestGaussians<float>> after;
  for (const bool fused : {true, false}) {
    const StoredScene<float> in(rough, memory());
    Optimised<float> state(rough, memory());
    Pipeline<float> pipeline(backend());
    pipeline.forward(in.forward(true));
    pipeline.loss(in.target(), true);
    BackwardArgs<float> args;
    args.regulariser = {0.5, 0.8};
    for (size_t set = 0; set < 2; ++set) args.sinks[set] = state.sink(set, 101, fused);
    pipeline.backward(args);
    for (size_t set = 0; set < 2 && !fused; ++set) backend().adam(args.sinks[set]);
    after.push_back(state.value[1].fetch());
  }
  for (const Group group : {kOpacityLogit, kLogScale})
    EXPECT_EQ(after[0].group[group], after[1].group[group]) << group_name(group, SetForm::kPair);
}

}  // namespace
}  // namespace tessera::testing
