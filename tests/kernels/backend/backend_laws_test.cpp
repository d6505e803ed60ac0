// Laws that hold for any scene, on every backend: batch, permutation, a static set equals its
// lifted dynamic set, reused memory. Source: failure mode C16.
#include "tests/support/backends.h"
#include "tests/support/compare.h"
#include "tests/support/render.h"

namespace tessera::testing {
namespace {

class BackendLaws : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendLaws);

TEST_P(BackendLaws, BatchIsTheMeanOfItsViews) {  // C16
  // Bug put back: no 1/B; seen to fail.
  TestScene<float> scene = random_scene(120, 120, 0.2, 71).as<float>();
  scene.views = five_views();
  Random random(72);
  fill_truth(scene, random);
  const float views = float(scene.views.size());
  const Backward<float> together = backward(scene, backend());
  TestGaussians<float> fixed(SetForm::kStatic, 120);
  TestGaussians<float> moving(SetForm::kPair, 120);
  size_t colour = 0;
  for (size_t b = 0; b < scene.views.size(); ++b) {
    TestScene<float> single = scene;
    single.views = {scene.views[b]};
    single.truth = {scene.truth[b]};
    const Backward<float> one = backward(single, backend());
    EXPECT_NEAR(one.losses[0].total, together.losses[b].total, 1e-6);
    for (const float c : one.rendered.colour) ASSERT_EQ(c, together.rendered.colour[colour++]);
    for (int g = 0; g < kGroupCount; ++g) {
      for (size_t i = 0; i < fixed.group[g].size(); ++i)
        fixed.group[g][i] += one.fixed.group[g][i] / views;
      for (size_t i = 0; i < moving.group[g].size(); ++i)
        moving.group[g][i] += one.moving.group[g][i] / views;
    }
  }
  for (int g = 0; g < kGroupCount; ++g) {
    // in float the views are summed before and after the chain rule; laws_test has it in double
    EXPECT_LE(relative(together.fixed.group[g], fixed.group[g]), 1e-4) << g;
    EXPECT_LE(relative(together.moving.group[g], moving.group[g]), 1e-4) << g;
  }
}

TEST_P(BackendLaws, OrderOfGaussiansDoesNotMatter) {
  // Bug put back: every other Gaussian 1e-3 redder; seen to fail.
  constexpr int64_t kCount = 150;
  const TestScene<float> scene = random_scene(kCount, kCount, 0.15, 73).as<float>();
  TestScene<float> shuffled = scene;
  std::vector<int64_t> order(kCount);
  for (int64_t n = 0; n < kCount; ++n) order[size_t(n)] = (7 * n + 3) % kCount;
  shuffled.fixed = scene.fixed.select(order);
  shuffled.moving = scene.moving.select(order);
  const Backward<float> a = backward(scene, backend()), b = backward(shuffled, backend());
  EXPECT_EQ(a.rendered.colour, b.rendered.colour);  // no two depths are equal
  for (int g = 0; g < kGroupCount; ++g) {
    EXPECT_LE(relative(b.fixed.group[g], a.fixed.select(order).group[g]), 5e-5) << g;
    EXPECT_LE(relative(b.moving.group[g], a.moving.select(order).group[g]), 5e-5) << g;
  }
}

TEST_P(BackendLaws, StaticIsTheLiftWithALongLife) {
  // Bug put back: dynamic means 1e-4 off; seen to fail.
  // as on the CPU in float (laws_test.cpp): w = σ_t² = 1e6, 1 − p(t) ≤ ½ 0.15²/w; dL/dl holds
  // parts ∝ w·rounding that cancel against dL/dr
  TestScene<double> still = random_scene(100, 0, 0.2, 74), lift = still;
  lift.moving = lifted(still.fixed, std::log(1e3));
  lift.fixed = TestGaussians<double>(SetForm::kStatic);
  const Backward<float> a = backward(still.as<float>(), backend());
  const Backward<float> b = backward(lift.as<float>(), backend());
  EXPECT_LE(relative(b.rendered.colour, a.rendered.colour), 5e-6);
  EXPECT_LE(relative(b.rendered.transmittance, a.rendered.transmittance), 5e-6);
  for (const Group g : {kMean, kLogScale, kOpacityLogit, kSh})
    EXPECT_LE(relative(b.moving.group[g], a.fixed.group[g]), 2e-4) << group_name(g, SetForm::kPair);
  std::vector<float> d_q = b.moving.group[kRotation];
  for (size_t i = 0; i < d_q.size(); ++i)
    d_q[i] += (i % 4 == 0 ? 1.0f : -1.0f) * b.moving.group[kRotationRight][i];
  EXPECT_LE(relative(d_q, a.fixed.group[kRotation]), 2e-4);
}

TEST_P(BackendLaws, ReusedBuffersLeaveNoTrace) {
  // Bug put back: tiles without instances not stored; seen to fail.
  const TestScene<float> large = random_scene(300, 300, 0.3, 75).as<float>();
  const TestScene<float> small = random_scene(2, 1, 0.05, 76).as<float>();
  const StoredScene<float> first(large, memory()), second(small, memory());
  Pipeline<float> pipeline(backend());
  const auto forward = [&](const StoredScene<float>& scene) {
    const Images<float>& images = pipeline.forward(scene.forward(true));
    return copy_of(images, pipeline.report(), memory());
  };
  forward(first);
  const Rendered<float> reused = forward(second), fresh = render(small, backend());
  EXPECT_EQ(reused.colour, fresh.colour);
  EXPECT_EQ(reused.transmittance, fresh.transmittance);
  EXPECT_EQ(reused.used, fresh.used);
  EXPECT_EQ(forward(first).colour, render(large, backend()).colour);
}

TEST_P(BackendLaws, OutcomeIsThatOfTheStepBeforeTheNextForward) {
  // Bug put back: losses reset by project; seen to fail.
  // as a trainer calls it: the next project has begun when the losses are asked for
  const TestScene<float> scene = random_scene(80, 80, 0.2, 77).as<float>();
  const Backward<float> expected = backward(scene, backend());
  const StoredScene<float> in(scene, memory());
  Pipeline<float> pipeline(backend());
  pipeline.forward(in.forward(true));
  pipeline.loss(in.target(), true);
  BackwardArgs<float> args;
  StoredGaussians<float> fixed(TestGaussians<float>(SetForm::kStatic, 80), memory());
  StoredGaussians<float> moving(TestGaussians<float>(SetForm::kPair, 80), memory());
  args.sinks[0].gradient = fixed.spans();
  args.sinks[1].gradient = moving.spans();
  pipeline.backward(args);
  TestScene<float> next = scene;
  next.views.pop_back();
  pipeline.forward(StoredScene<float>(next, memory()).forward(true));
  const StepOutcome outcome = pipeline.outcome();
  ASSERT_EQ(outcome.losses.size(), expected.losses.size());
  for (size_t b = 0; b < expected.losses.size(); ++b)
    EXPECT_NEAR(outcome.losses[b].total, expected.losses[b].total, 1e-7);
  EXPECT_EQ(outcome.bad_groups, 0u);
}

}  // namespace
}  // namespace tessera::testing
