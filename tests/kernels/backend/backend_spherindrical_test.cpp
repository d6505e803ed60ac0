// Time-varying colours on every backend: images and gradients against the oracle, the fused
// optimizer against the separate one, and sets without levels against sets whose levels are not
// active.
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/optimised.h"

namespace tessera::testing {
namespace {

/// Levels in a scene of both sets; rows of 12 or 48 scalars are read in fours, of 27 one by one.
TestScene<double> levelled_scene(SetForm form, int levels, uint64_t seed, int coefficients = 16) {
  TestScene<double> scene = random_scene(60, 0, 0.12, seed, form);
  Random random(seed + 1);
  scene.moving = random_gaussians(form, 150, 0.9, 0.12, random, coefficients);
  add_time_levels(scene.moving, levels, seed + 2);
  keep_truth_away(scene, seed + 3);
  return scene;
}

class BackendSpherindrical : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendSpherindrical);

TEST_P(BackendSpherindrical, ImagesAndGradientsAreTheOracles) {
  // Bugs put back in float alone, each seen to fail: weights left out of the gradient; the slope
  // left out of the mean time's; levels left out of the colour.
  struct Case {
    SetForm form;
    int levels, active, coefficients;
  };
  for (const auto& [form, levels, active, coefficients] : {Case{SetForm::kPair, 2, 2, 16},
                                                           {SetForm::kVelocity, 2, 1, 16},
                                                           {SetForm::kPair, 1, 1, 9},
                                                           {SetForm::kVelocity, 2, 2, 9},
                                                           {SetForm::kVelocity, 1, 1, 4},
                                                           {SetForm::kPair, 2, 2, 1}}) {
    SCOPED_TRACE(std::string(form_name(form)) + ", coefficients " + std::to_string(coefficients));
    TestScene<double> scene = levelled_scene(form, levels, 81, coefficients);
    scene.options.sh_time_degree = active;
    scene.options.sh_time_period = 0.9;
    keep_truth_away(scene, 85);
    const Backward<float> actual = backward(scene.as<float>(), backend());
    const Backward<double> expected = backward(scene);
    EXPECT_EQ(actual.bad, 0u);
    expect_batch(actual.rendered.colour, actual.rendered.transmittance, expected.rendered,
                 critical_pixels(scene));
    for (int g = 0; g < kGroupCount; ++g)
      expect_group(actual.moving.group[g], expected.moving.group[g], kGradientBounds,
                   group_name(Group(g), form));
  }
}

TEST_P(BackendSpherindrical, ReportsLevelsThatAreNotFinite) {  // C20
  // Bug put back: their bit not set; seen to fail.
  const TestScene<float> scene = levelled_scene(SetForm::kPair, 1, 83).as<float>();
  const auto result = backward<float>(scene, backend(), [](std::vector<float>& d) {
    for (float& x : d) x = std::numeric_limits<float>::quiet_NaN();
  });
  EXPECT_EQ(result.bad, (1u << kDynamicGroups) - 1);
}

/// Bit for bit: sets that store levels which are not active are drawn and trained as those without.
TEST_P(BackendSpherindrical, NotActiveIsAsNone) {
  // Bug put back: levels evaluated beyond sh_time_degree; seen to fail.
  for (const SetForm form : kDynamicForms) {
    TestScene<float> scene = levelled_scene(form, 2, 87).as<float>();
    scene.options.kernels.deterministic = true;
    scene.options.sh_time_degree = 0;
    TestScene<float> none = scene;
    none.moving.time_levels = 0;
    none.moving.group[kShTime].clear();
    const Backward<float> a = backward(scene, backend()), b = backward(none, backend());
    EXPECT_EQ(a.rendered.colour, b.rendered.colour);
    for (int g = 0; g < kShTime; ++g) EXPECT_EQ(a.moving.group[g], b.moving.group[g]);
    for (const float g : a.moving.group[kShTime]) ASSERT_EQ(g, 0.0f);
  }
}

/// A step of the optimizer on the gradient of the whole chain.
TestGaussians<float> stepped(const TestScene<float>& scene, Backend& backend, bool fused) {
  const StoredScene<float> in(scene, backend.memory());
  Optimised<float> state(scene, backend.memory());
  Pipeline<float> pipeline(backend);
  pipeline.forward({{state.value[0].view(), state.value[1].view()}, in.views, in.options, true});
  pipeline.loss(in.target(), true);
  BackwardArgs<float> args;
  for (size_t set = 0; set < 2; ++set) args.sinks[set] = state.sink(set, 101, fused);
  pipeline.backward(args);
  for (size_t set = 0; set < 2 && !fused; ++set) backend.adam(args.sinks[set]);
  return state.value[1].fetch();
}

TEST_P(BackendSpherindrical, FusedEqualsSeparate) {
  // Bug put back: levels left out of the separate one; seen to fail.
  for (const int coefficients : {16, 9}) {
    TestScene<float> scene = levelled_scene(SetForm::kVelocity, 2, 89, coefficients).as<float>();
    scene.options.kernels.deterministic = true;
    const TestGaussians<float> fused = stepped(scene, backend(), true);
    const TestGaussians<float> separate = stepped(scene, backend(), false);
    for (int g = 0; g < kGroupCount; ++g)
      EXPECT_EQ(fused.group[g], separate.group[g]) << group_name(Group(g), SetForm::kVelocity);
    EXPECT_NE(fused.group[kShTime], scene.moving.group[kShTime]);
  }
}

}  // namespace
}  // namespace tessera::testing
