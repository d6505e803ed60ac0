// Trainings of time-varying colours: a known answer, the steps at which levels become active, and
// resumed checkpoints.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "recon4d/training/schedule.h"
#include "tests/support/random.h"
#include "tests/support/resume.h"

namespace tessera::testing {
namespace {

constexpr double kBase[] = {0.5, 0.4, 0.55}, kSwing[] = {0.3, -0.2, 0.1};

/// Two cameras at eight timesteps before a wall of colour base + swing·cos(2πt).
Scene changing_wall() {
  Scene scene = tiny_capture({.cameras = 2, .timesteps = 8, .size = 12});
  for (Frame& frame : scene.frames)
    for (size_t i = 0; i < frame.image.data.size(); ++i)
      frame.image.data[i] = uint8_t(
          std::lround(255 * (kBase[i % 3] + kSwing[i % 3] * std::cos(2 * M_PI * frame.time))));
  return scene;
}

/// One opaque Gaussian that fills every image for the whole clip; only colours are trained.
TrainOptions wall_options(int64_t levels) {
  TrainOptions options;
  options.iterations = options.schedule_iterations = 300;
  options.batch = 4;
  options.sh_degree = 0;
  options.sh_interval = 1;
  options.sh_time_degree = levels;
  options.densify_until = 0;
  options.lambda_dssim = 0;
  options.lr_mean = options.lr_mean_final = options.lr_mean_time = options.lr_scale = 0;
  options.lr_scale_time = options.lr_rotation = options.lr_opacity = 0;
  options.lr_sh = options.lr_sh_rest = 0.01;
  return options;
}

TrainState one_gaussian(const Scene& scene, const TrainOptions& options) {
  TrainOptions one = options;
  one.init_points = 1;
  one.carve = false;
  TrainState state = first_state(scene, one);
  const GaussianSpans<float> g = state.model.dynamic_set.values();
  EXPECT_EQ(g.count, 1);
  std::fill_n(g.at(kMean, 0), 3, 0.0f);
  std::fill_n(g.at(kLogScale, 0), 3, std::log(30.0f));
  *g.at(kMeanTime, 0) = 0;
  *g.at(kLogScaleTime, 0) = std::log(30.0f);
  *g.at(kOpacityLogit, 0) = 7;
  return state;
}

// Known answer: c_0 = (base − ½)/Y_0, c_1 = swing/Y_0. Without a level the best is the median.
// Bugs put back, each seen to fail: the gradient of a level without its cosine; a level that never
// becomes active.
TEST(TrainSpherindrical, AWallThatChangesColourIsFitted) {
  const Scene scene = changing_wall();
  Training with(scene, wall_options(1), one_gaussian(scene, wall_options(1)));
  Training without(scene, wall_options(0), one_gaussian(scene, wall_options(0)));
  with.run();
  without.run();
  EXPECT_GT(with.psnr(), 35);
  EXPECT_LT(without.psnr(), 18);
  const GaussianSpans<const float> g = with.model().dynamic_set.values();
  ASSERT_EQ(g.count, 1);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(kSh0 * double(g.at(kSh, 0)[c]), kBase[c] - 0.5, 0.01) << c;
    EXPECT_NEAR(kSh0 * double(g.at(kShTime, 0)[c]), kSwing[c], 0.01) << c;
  }
  EXPECT_EQ(without.model().dynamic_set.group(kShTime).value.size(), 0);
}

// D.3: SH degrees first, then a level at a time. Bug put back: both ramps at once; seen to fail.
TEST(TrainSpherindrical, LevelsFollowTheDegrees) {
  TrainOptions options;
  options.sh_time_degree = 2;
  const Schedule schedule(options, 1);
  const int64_t steps[] = {0, 3000, 3999, 4000, 4999, 5000, 29999};
  const int levels[] = {0, 0, 0, 1, 1, 2, 2};
  for (size_t k = 0; k < std::size(steps); ++k)
    EXPECT_EQ(schedule.sh_time_degree(steps[k]), levels[k]) << steps[k];
  options.sh_time_degree = 1;
  options.sh_degree = 1;
  EXPECT_EQ(Schedule(options, 1).sh_time_degree(1999), 0);
  EXPECT_EQ(Schedule(options, 1).sh_time_degree(2000), 1);
  EXPECT_EQ(Schedule(options, 1).sh_time_degree(29999), 1);
}

TrainOptions levelled_options() {
  TrainOptions options = tiny_options();
  options.sh_degree = 1;
  options.sh_interval = 5;
  options.sh_time_degree = 2;
  return options;
}

// Bugs put back, each seen to fail: sh_time_degree not restored; nor the moments of the levels.
TEST(TrainSpherindrical, ResumeIsBitEqual) {
  const Scene scene = tiny_capture();
  for (const IdleUpdate idle : {IdleUpdate::kDense, IdleUpdate::kSkip}) {
    TrainOptions options = levelled_options();
    options.idle_updates = idle;
    options.motion = Motion::kVelocity;
    Training whole(scene, options);
    whole.run();
    EXPECT_EQ(whole.model().drawing.sh_time_degree, 2);
    expect_resumes(scene, options, 22, whole, [](const TrainState& state) {
      const Buffer<float>& moments = state.model.dynamic_set.group(kShTime).moment1;
      EXPECT_TRUE(std::any_of(moments.begin(), moments.end(), [](float word) { return word != 0; }))
          << "or nothing is tested";
    });
  }
}

TEST(TrainSpherindrical, ACheckpointHasTheNumberOfLevels) {
  const Scene scene = tiny_capture();
  Training training(scene, levelled_options());
  training.run(3);
  const ScratchFolder folder;
  save_checkpoint(folder / "run.ckpt", training.state(), levelled_options(), {});
  EXPECT_TRUE(state_bits(load_checkpoint(folder / "run.ckpt").state) ==
              state_bits(training.state()));
  EXPECT_EQ(read_checkpoint_header(folder / "run.ckpt")["sh_time_levels"], 2);
}

}  // namespace
}  // namespace tessera::testing
