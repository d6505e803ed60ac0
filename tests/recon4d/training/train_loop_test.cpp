// The training loop as a whole: the loss falls, and equal inputs give equal bytes.
#include <gtest/gtest.h>
#include <bit>

#include "kernels/base/parallel.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/checkpoint.h"
#include "tests/support/random.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

/// Mean loss of steps [begin, end).
double mean_loss(const Training& training, size_t begin, size_t end) {
  double sum = 0;
  for (size_t i = begin; i < end; ++i) sum += training.steps()[i].loss;
  return sum / double(end - begin);
}

TrainOptions learning_options(double static_fraction) {
  TrainOptions options = tiny_options();
  options.iterations = options.schedule_iterations = 300;
  options.batch = 4;
  options.init_points = 150;
  options.static_fraction = static_fraction;
  options.densify_from = 50;
  options.densify_until = 200;
  options.densify_interval = 50;
  options.prune_large_from = 300;
  options.sh_degree = 1;
  options.sh_interval = 100;
  return options;
}

/// `floor`: dB, some 2 to 4 below what the training reaches.
void expect_learns(const TinyCapture& capture, double static_fraction, double floor) {
  const Scene scene = tiny_capture(capture);
  Training training(scene, learning_options(static_fraction));
  EXPECT_LT(training.psnr(), 15) << "nothing is left to learn";
  training.run();
  EXPECT_LT(mean_loss(training, 280, 300), 0.2 * mean_loss(training, 0, 20));
  EXPECT_GT(training.psnr(), floor);
  EXPECT_TRUE(training.state().finished);
}

TEST(TrainLoop, StaticSceneIsLearnt) {
  expect_learns({.cameras = 12, .timesteps = 1, .moving = false}, 0, 38);
}

TEST(TrainLoop, DynamicSceneIsLearnt) {
  expect_learns({}, 0, 28);
}

TEST(TrainLoop, MixedSetsLearnTogether) {
  expect_learns({}, 0.5, 31);
}

// Bug put back: std::rand() as the seed of the sampler; seen to fail. (C18)
TEST(TrainLoop, SameSeedSameBytes) {
  const Scene scene = tiny_capture();
  Training a(scene, tiny_options());
  Training b(scene, tiny_options());
  EXPECT_TRUE(state_bits(a.run().state()) == state_bits(b.run().state()));
}

TEST(TrainLoop, AnotherSeedAnotherModel) {
  const Scene scene = tiny_capture();
  TrainOptions other = tiny_options();
  other.seed = 2;
  Training a(scene, tiny_options());
  Training b(scene, other);
  EXPECT_NE(model_bits(a.run().model()), model_bits(b.run().model()));
}

// Bug put back: gradients of a splat summed in an order that depends on the threads; seen to fail.
TEST(TrainLoop, ThreadsDoNotChangeBytes) {
  const Scene scene = tiny_capture({.size = 32});
  TrainOptions options = tiny_options();
  options.init_points = 1500;  // several tasks in every stage
  set_thread_count(1);
  Training one(scene, options);
  one.run();
  set_thread_count(2);
  Training two(scene, options);
  two.run();
  set_thread_count(0);
  EXPECT_TRUE(state_bits(one.state()) == state_bits(two.state()));
}

// Bug put back: the sampler is not restored from the checkpoint; seen to fail. (E5)
TEST(TrainLoop, ResumeIsBitEqual) {
  const Scene scene = tiny_capture();
  const TrainOptions options = tiny_options();
  Training whole(scene, options);
  whole.run();
  EXPECT_GT(whole.density().size(), 4u) << "density control must act before and after the break";

  const ScratchFolder folder;
  // 20 is between two density controls, so statistics matter; 24 is just before one
  for (int64_t half : {20, 24, 39}) {
    Training first(scene, options);
    first.run(half);
    ASSERT_EQ(first.state().iteration, half);
    save_checkpoint(folder / "half.ckpt", first.state(), options, {});
    Checkpoint loaded = load_checkpoint(folder / "half.ckpt");
    ASSERT_EQ(state_bits(loaded.state), state_bits(first.state()));
    Training second(scene, loaded.options, std::move(loaded.state));
    second.run();
    EXPECT_TRUE(state_bits(second.state()) == state_bits(whole.state())) << "stopped at " << half;
  }
}

// Bug put back: the loss gradient is not divided by the batch; seen to fail. (C16)
TEST(TrainLoop, BatchOfEqualViewsIsOneView) {
  const Scene scene = tiny_capture({.cameras = 1, .timesteps = 1});
  TrainOptions single = tiny_options();
  single.batch = 1;
  single.iterations = 1;
  TrainOptions three = single;
  three.batch = 3;
  const auto oblong = [&](const TrainOptions& options) {  // a ball's rotation has no gradient
    TrainState state = first_state(scene, options);
    for (int64_t n = 0; n < state.model.static_set.count(); ++n)
      state.model.static_set.values().at(kLogScale, n)[n % 3] += 0.5f;
    return state;
  };
  Training a(scene, single, oblong(single));
  Training b(scene, three, oblong(three));
  a.run();
  b.run();
  EXPECT_NEAR(a.steps()[0].loss, b.steps()[0].loss, 1e-7);
  // Adam's first step only keeps signs; its first moment is a tenth of the gradient
  const GaussianSet &x = a.model().static_set, &y = b.model().static_set;
  ASSERT_EQ(x.count(), y.count());
  for (int g = 0; g < x.groups(); ++g) {
    const bool packed = packs_moments(Group(g));
    const auto first_moments = [&](const GaussianSet& set) {
      std::vector<float> all(set.group(Group(g)).moment1.begin(),
                             set.group(Group(g)).moment1.end());
      for (float& m : all)
        if (packed) m = unpacked_moments(std::bit_cast<uint32_t>(m)).m;
      return all;
    };
    const std::vector<float> mx = first_moments(x), my = first_moments(y);
    float largest = 0;
    for (float m : mx) largest = std::max(largest, std::abs(m));
    EXPECT_GT(largest, 0) << group_name(Group(g), SetForm::kStatic);
    for (size_t i = 0; i < mx.size(); ++i)
      EXPECT_NEAR(mx[i], my[i], 1e-5f * largest + (packed ? std::abs(mx[i]) / 64 : 0))
          << group_name(Group(g), SetForm::kStatic) << " " << i;
  }
}

/// Masks that ignore a third of every second image, which holds noise there.
Scene masked_capture(uint64_t seed) {
  Scene scene = tiny_capture();
  Random random(seed);
  for (size_t i = 0; i < scene.frames.size(); i += 2) {
    Frame& frame = scene.frames[i];
    Image8 mask{frame.image.width, frame.image.height, 1, {}};
    const int pixels = frame.image.width * frame.image.height;
    for (int p = 0; p < pixels; ++p) {
      const bool used = p % frame.image.width > frame.image.width / 3;
      mask.data.push_back(used ? 255 : 0);
      for (size_t c = 0; c < 3 && !used; ++c)
        frame.image.data[3 * size_t(p) + c] = uint8_t(random.below(256));
    }
    frame.mask = std::move(mask);
  }
  return scene;
}

// B17. Bug put back: masks not passed on to the loss; seen to fail.
TEST(TrainLoop, WhatMasksIgnoreChangesNoByte) {
  const Scene one = masked_capture(1), other = masked_capture(2);
  ASSERT_NE(one.frames[0].image.data, other.frames[0].image.data);
  Training a(one, tiny_options());
  Training b(other, tiny_options());
  EXPECT_TRUE(state_bits(a.run().state()) == state_bits(b.run().state()));
}

/// One timestep is trained through Dim 3, and the model has no notion of time.
// Bug put back: is_static of the scene is ignored by initialise_model; seen to fail. (B13)
TEST(TrainLoop, OneTimestepIsStatic) {
  const Scene scene = tiny_capture({.timesteps = 1});
  TrainOptions options = tiny_options(), static_only = tiny_options();
  static_only.motion = Motion::kNone;
  Training a(scene, options);
  Training b(scene, static_only);
  a.run();
  b.run();
  EXPECT_EQ(a.model().dynamic_set.count(), 0);
  EXPECT_GT(a.model().static_set.count(), 0);
  EXPECT_TRUE(state_bits(a.state()) == state_bits(b.state()));

  const std::unique_ptr<Backend> backend = make_cpu_backend();
  const Camera& camera = scene.frames[0].camera;
  const std::vector<RenderedImage> drawn =
      render_views(*backend, a.model(), {{camera, 0}, {camera, 0.7}});
  EXPECT_EQ(drawn[0].rgb, drawn[1].rgb);
}

}  // namespace
}  // namespace tessera::testing
