// What: gains of the images in the loss of every backend, against the oracle on images that
//       span many tiles of the loss, with masks and without; equal inputs give equal bits.
// Not: their gradient against differences (exposure_test.cpp). Source: B10.
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/stage_run.h"

namespace tessera::testing {
namespace {

class BackendExposure : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendExposure);

TestScene<double> gained_scene(uint64_t seed, bool masked) {
  TestScene<double> scene = large_scene(seed);
  Random random(seed + 3);
  for (size_t b = 0; b < scene.views.size(); ++b) {
    scene.gain.emplace_back(random.uniform(0.7, 1.3), random.uniform(0.7, 1.3),
                            random.uniform(0.7, 1.3));
    scene.mask.emplace_back();
    for (size_t p = 0; p < scene.truth[b].size() / 3 && masked && b != 1; ++p)
      scene.mask.back().push_back(random.below(5) > 0 ? 255 : 0);
  }
  return scene;
}

/// The loss stage alone, on images that lie in the backend's memory.
struct LossOf {
  std::vector<float> d_colour;
  StepOutcome outcome;

  LossOf(const TestScene<float>& scene, const std::vector<float>& colour, Backend& backend) {
    const StoredScene<float> in(scene, backend.memory());
    const ViewBatch<float> batch = make_view_batch<float>(scene.views);
    Images<float> images(backend.memory());
    images.colour = stored(colour, backend.memory());
    Buffer<float> gradient(int64_t(colour.size()), backend.memory());
    const Target target = in.target();
    backend.photometric({&batch, &images, target.truth, target.weights, target.mask, target.gain},
                        gradient.span());
    d_colour = fetched(gradient, backend.memory());
    outcome = backend.outcome();
  }
};

// With a gain or on images that were multiplied by it beforehand: the same loss.
// Bugs put back, each seen to fail on the CPU: gains of the next view; the image's gradient
// without the gain; the last row left out of the gain's gradient; ignored pixels compared with what
// was rendered before its gain.
TEST_P(BackendExposure, IsTheLossOfTheProduct) {
  TestScene<float> scene = gained_scene(75, true).as<float>();
  const std::vector<float> colour = run_stages(scene, backend()).colour;
  std::vector<float> product = colour;
  const ViewBatch<float> batch = make_view_batch<float>(scene.views);
  const auto each = [&](auto&& body) {
    for (size_t b = 0; b < scene.views.size(); ++b) {
      const ViewArgs<float>& view = batch.views[b];
      const int64_t pixels = int64_t(view.width) * view.height;
      for (int64_t i = 0; i < 3 * pixels; ++i)
        body(b, int(i / pixels), size_t(3 * view.first_pixel + i));
    }
  };
  const std::vector<Vec3<double>> gain = scene.gain;
  each([&](size_t b, int c, size_t i) { product[i] *= float(gain[b][c]); });
  const LossOf with(scene, colour, backend());
  scene.gain.clear();
  const LossOf by_hand(scene, product, backend());
  std::vector<float> expected = by_hand.d_colour;
  std::vector<Vec3<double>> d_gain(scene.views.size(), Vec3<double>(0));
  each([&](size_t b, int c, size_t i) {
    expected[i] *= float(gain[b][c]);
    d_gain[b][c] += double(by_hand.d_colour[i]) * double(colour[i]);
  });
  expect_group(with.d_colour, expected, {1e-4, 1e-4, 0, 1e-5}, "picture");
  for (size_t b = 0; b < scene.views.size(); ++b) {
    EXPECT_NEAR(with.outcome.losses[b].total, by_hand.outcome.losses[b].total, 1e-6);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(with.outcome.d_gain[b][c], d_gain[b][c], 1e-4 * std::abs(d_gain[b][c]) + 1e-7);
  }
}

// For a device's kernels; the oracle is the CPU's own code, which the test above and
// exposure_test.cpp hold to account.
// Bug put back: sums that begin where those of the last call ended; seen to fail on the CPU.
TEST_P(BackendExposure, LossAndGradientsEqualTheOracles) {
  for (const bool masked : {false, true}) {
    SCOPED_TRACE(masked);
    const TestScene<double> scene = gained_scene(73, masked);
    const Backward<double> expected = backward(scene);
    const Backward<float> actual = backward(scene.as<float>(), backend());
    EXPECT_EQ(actual.bad, 0u);
    ASSERT_EQ(actual.d_gain.size(), scene.views.size());
    std::vector<double> d_gain[2];
    for (size_t b = 0; b < scene.views.size(); ++b) {
      EXPECT_NEAR(actual.losses[b].l1, expected.losses[b].l1,
                  5e-6);  // as backend_gradient_test.cpp
      EXPECT_NEAR(actual.losses[b].ssim, expected.losses[b].ssim, 2e-5);
      for (int c = 0; c < 3; ++c) {
        d_gain[0].push_back(actual.d_gain[b][c]);
        d_gain[1].push_back(expected.d_gain[b][c]);
      }
    }
    expect_group(d_gain[0], d_gain[1], {2e-4, 2e-4, 0, 2e-4}, "gain");
    for (int g = 0; g < kGroupCount; ++g)
      expect_group(actual.moving.group[g], expected.moving.group[g], kGradientBounds,
                   group_name(Group(g), Form::kPair));
  }
}

// Bug put back: gains 0.01 % off; seen to fail on the CPU.
TEST_P(BackendExposure, OneIsNone) {
  TestScene<float> scene = gained_scene(77, true).as<float>();
  scene.gain.clear();
  const StageRun<float> without = run_stages(scene, backend());
  EXPECT_TRUE(without.d_gain.empty());
  scene.gain.assign(scene.views.size(), Vec3<double>(1));
  const StageRun<float> with = run_stages(scene, backend());
  ASSERT_EQ(with.d_gain.size(), scene.views.size());
  // each template of a device's kernel may fuse its sums in its own way: a step or two of float
  for (size_t i = 0; i < without.d_colour.size(); ++i)
    EXPECT_NEAR(with.d_colour[i], without.d_colour[i], 1e-5 * std::abs(without.d_colour[i]) + 1e-9);
  for (size_t b = 0; b < scene.views.size(); ++b)
    EXPECT_NEAR(with.losses[b].total, without.losses[b].total, 1e-6);
}

// Bug put back: sums that begin where those of the last call ended; seen to fail on the CPU.
TEST_P(BackendExposure, EqualInputsGiveEqualBits) {
  const TestScene<float> scene = gained_scene(79, true).as<float>();
  const StageRun<float> one = run_stages(scene, backend()), other = run_stages(scene, backend());
  EXPECT_EQ(one.d_colour, other.d_colour);
  for (size_t b = 0; b < scene.views.size(); ++b) EXPECT_EQ(one.d_gain[b], other.d_gain[b]) << b;
}

// Without a gradient there is none by the gains either.
// Bug put back: zeros for it; seen to fail on the CPU.
TEST_P(BackendExposure, LossAloneIsThatOfTheGainedImage) {
  const TestScene<float> scene = gained_scene(81, false).as<float>();
  const StoredScene<float> in(scene, memory());
  Pipeline<float> pipeline(backend());
  pipeline.forward(in.forward(true));
  pipeline.loss(in.target(), true);
  const StepOutcome with = pipeline.outcome();
  pipeline.loss(in.target());
  const StepOutcome alone = pipeline.outcome();
  EXPECT_TRUE(alone.d_gain.empty());
  for (size_t b = 0; b < scene.views.size(); ++b)
    EXPECT_EQ(alone.losses[b].total, with.losses[b].total);
}

}  // namespace
}  // namespace tessera::testing
