// What: terms in velocities and lives, and the temporal filter, of every backend against the
// oracle's, and of the fused optimizer against the separate one.
// Not: that the oracle is right (motion_terms_test.cpp, brute_force_test.cpp, gradient_test.cpp).
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/motion_scene.h"
#include "tests/support/optimised.h"

namespace tessera::testing {
namespace {

class BackendMotion : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendMotion);

const RegulariserWeights kWeights{0, 0, 0.4, 0.6, 0.9, 0.05};

TEST_P(BackendMotion, TermsAreTheOracles) {
  // Bug put back: only Gaussians that are seen; seen to fail.
  for (const Form form : kDynamicForms) {
    TestScene<double> scene = motion_scene(form, 90, 300, 71);
    scene.regulariser = kWeights;
    const TestScene<float> rough = scene.as<float>();
    const Backward<float> actual = backward(rough, backend());
    const Backward<double> expected = backward(rough.as<double>());
    EXPECT_EQ(actual.bad, 0u);
    for (int g = 0; g < kGroupCount; ++g)
      expect_group(actual.moving.group[g], expected.moving.group[g], kGradientBounds,
                   group_name(Group(g), form));
    for (int64_t n = 0; n < 300; n += 3)  // of these there is nothing but the terms
      for (const Group group : {kLogScaleTime, kRotationRight})
        for (int k = 0; k < group_width(group, 0, form); ++k)
          EXPECT_NEAR(actual.moving.at(group, n)[k], expected.moving.at(group, n)[k],
                      2e-6 + 1e-4 * std::abs(expected.moving.at(group, n)[k]));
  }
}

TEST_P(BackendMotion, TermsReachTheFusedOptimizer) {
  // Bug put back: the terms left out of one of the sinks; seen to fail.
  for (const Form form : kDynamicForms) {
    TestScene<double> scene = motion_scene(form, 10, 150, 72);
    scene.options.kernels.deterministic = true;
    const TestScene<float> rough = scene.as<float>();
    const StoredPairs<float> pairs(scene.pairs, memory());
    std::vector<TestGaussians<float>> after;
    for (const bool fused : {true, false}) {
      const StoredScene<float> in(rough, memory());
      Optimised<float> state(rough, memory());
      Pipeline<float> pipeline(backend());
      // the values that are drawn are those that the optimizer changes
      pipeline.forward(
          {{state.value[0].view(), state.value[1].view()}, in.views, in.options, {}, true});
      pipeline.loss(in.target(), true);
      BackwardArgs<float> args;
      args.regulariser = kWeights, args.pairs = pairs.view();
      for (size_t set = 0; set < 2; ++set) args.sinks[set] = state.sink(set, 101, fused);
      pipeline.backward(args);
      for (size_t set = 0; set < 2 && !fused; ++set) backend().adam(args.sinks[set]);
      after.push_back(state.value[1].fetch());
    }
    for (int g = 0; g < kGroupCount; ++g)
      EXPECT_EQ(after[0].group[g], after[1].group[g]) << group_name(Group(g), form);
    EXPECT_NE(after[0].group[kLogScaleTime], rough.moving.group[kLogScaleTime]);
  }
}

TEST_P(BackendMotion, TimeFilterIsTheOracles) {
  // Bugs put back, each seen to fail: the filter ignored; ignored in the backward pass alone.
  for (const Form form : kDynamicForms) {
    TestScene<double> scene = random_scene(40, 120, 0.12, 73, form);
    for (double& s : scene.moving.group[kLogScaleTime]) s -= 1;
    scene.options.time_filter = 0.04;
    keep_truth_away(scene, 74);
    const Backward<float> actual = backward(scene.as<float>(), backend());
    const Backward<double> expected = backward(scene);
    expect_batch(actual.rendered.colour, actual.rendered.transmittance, expected.rendered,
                 critical_pixels(scene));
    for (int g = 0; g < kGroupCount; ++g)
      expect_group(actual.moving.group[g], expected.moving.group[g], kGradientBounds,
                   group_name(Group(g), form));
  }
}

}  // namespace
}  // namespace tessera::testing
