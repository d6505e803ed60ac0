// What: lazy updates of idle Gaussians train what dense ones do; skipping does not.
// Not: the closed form itself (tests/kernels). Source: method G.3.
#include <gtest/gtest.h>

#include <cmath>

#include "recon4d/model/checkpoint.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/tiny_capture.h"

namespace tessera {
namespace {

using testing::first_state;
using testing::model_bits;
using testing::ScratchFolder;
using testing::state_bits;
using testing::tiny_capture;
using testing::tiny_options;
using testing::Training;

/// One view a step and short-lived Gaussians: most are idle in most steps.
TrainOptions idle_options(const std::string& idle) {
  TrainOptions options = tiny_options();
  options.iterations = options.schedule_iterations = 300;
  options.batch = 1, options.init_points = 150, options.static_fraction = 0.3;
  options.init_time_scale = 0.1;
  options.sh_interval = 60, options.densify_until = 0, options.reorder_interval = 0;
  options.idle_updates = idle;
  return options;
}

std::vector<int32_t> steps_of(const TrainState& state) {
  std::vector<int32_t> steps;
  for (const SetStatistics& statistics : state.statistics)
    steps.insert(steps.end(), statistics.sh_step.begin(), statistics.sh_step.end());
  return steps;
}
double share_behind(const TrainState& state) {
  const std::vector<int32_t> steps = steps_of(state);
  return double(std::count_if(steps.begin(), steps.end(),
                              [&](int32_t s) { return s < state.iteration; })) /
         double(steps.size());
}

/// Largest difference of a value of two models of equal counts.
double worst_difference(const GaussianModel& a, const GaussianModel& b) {
  double worst = 0;
  for (auto set : {&GaussianModel::static_set, &GaussianModel::dynamic_set})
    for (int g = 0; g < (a.*set).groups(); ++g) {
      const Buffer<float>&x = (a.*set).group(Group(g)).value, &y = (b.*set).group(Group(g)).value;
      if (x.size() != y.size()) return INFINITY;
      for (int64_t i = 0; i < x.size(); ++i) worst = std::max(worst, double(std::abs(x[i] - y[i])));
    }
  return worst;
}

/// What a training ends with, compared with dense.
struct Ends {
  double difference;  // largest of a value, before the clean-up and after it
  double psnr;        // dB
};

Ends compared(const std::string& idle, const TrainOptions& dense_options) {
  const Scene scene = tiny_capture();
  TrainOptions options = dense_options;
  options.idle_updates = idle;
  Training dense(scene, dense_options), other(scene, options);
  dense.run(options.iterations - 1), other.run(options.iterations - 1);  // before the clean-up
  const double difference =
      worst_difference(dense.model(), caught_up_model(other.state(), options));
  dense.run(), other.run();
  return {std::max(difference, worst_difference(dense.model(), other.model())),
          other.psnr() - dense.psnr()};
}

// Bugs put back, each seen to fail: project knows nothing of laziness; the rate of the first
// coefficient for all; no catching up before the last clean-up.
TEST(TrainLazy, IsTheTrajectoryOfDense) {
  const Ends lazy = compared("lazy", idle_options("dense"));
  const Ends skip = compared("skip", idle_options("dense"));
  EXPECT_LT(lazy.difference, 1e-4) << "seen: 2.9e-6";
  EXPECT_LT(std::abs(lazy.psnr), 0.001) << "dB; seen: 2e-8";
  EXPECT_GT(skip.difference, 0.1) << "what lazy avoids; seen: 2.2";
}

/// Rounding decides here and there what is cloned, so the models differ, not their quality.
// Bug put back: no catching up before density control; seen to fail.
TEST(TrainLazy, WithDensityControlTheQualityIsThatOfDense) {
  TrainOptions options = idle_options("dense");
  options.densify_from = 30, options.densify_until = 200, options.densify_interval = 40;
  options.reorder_interval = 50, options.prune_large_from = 300;
  const Ends lazy = compared("lazy", options);
  EXPECT_LT(std::abs(lazy.psnr), 0.1) << "dB; seen: 0.0013";
}

TEST(TrainLazy, MostAreBehindOnTheWayAndNoneAtTheEnd) {
  const Scene scene = tiny_capture();
  Training training(scene, idle_options("lazy"));
  training.run(100);
  EXPECT_GT(share_behind(training.state()), 0.3);
  training.run();
  EXPECT_EQ(share_behind(training.state()), 0);
}

// Bugs put back, each seen to fail: the checkpoint holds colours that were caught up; sh_step is
// not restored.
TEST(TrainLazy, ResumeGoesOnBitForBit) {
  const Scene scene = tiny_capture();
  TrainOptions options = tiny_options();
  options.idle_updates = "lazy", options.batch = 1, options.init_time_scale = 0.1;
  Training whole(scene, options);
  whole.run();
  const ScratchFolder folder;
  for (int64_t half : {20, 24, 39}) {
    Training first(scene, options);
    first.run(half);
    ASSERT_GT(share_behind(first.state()), 0) << "or nothing is tested";
    save_checkpoint(folder / "half.ckpt", first.state(), options, {});
    Checkpoint loaded = load_checkpoint(folder / "half.ckpt");
    EXPECT_EQ(loaded.options.idle_updates, "lazy");
    EXPECT_EQ(steps_of(loaded.state), steps_of(first.state()));
    Training second(scene, loaded.options, std::move(loaded.state));
    second.run();
    EXPECT_TRUE(state_bits(second.state()) == state_bits(whole.state())) << "stopped at " << half;
  }
}

/// The model that is handed out is up to date, and handing it out changes nothing.
// Bug put back: the state itself is caught up for an evaluation; seen to fail.
TEST(TrainLazy, LookingDoesNotTouch) {
  const Scene scene = tiny_capture();
  const TrainOptions options = idle_options("lazy");
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  Observer silent;
  Trainer watched(*backend, scene, options, first_state(scene, options), silent);
  Training dense(scene, idle_options("dense")), alone(scene, options);
  for (int64_t pause : {40, 80, 120}) {
    watched.run(pause), dense.run(pause), alone.run(pause);
    EXPECT_GT(worst_difference(watched.state().model, dense.model()), 1e-3) << "some are behind";
    EXPECT_LT(worst_difference(watched.host_model(), dense.model()), 1e-4);
    EXPECT_EQ(&watched.host_state(), &watched.state()) << "no copy on the host";
    EXPECT_TRUE(state_bits(watched.state()) == state_bits(alone.state()));
  }
  const GaussianModel saved = caught_up_model(watched.state(), options);
  EXPECT_TRUE(model_bits(saved) == model_bits(watched.host_model()));
}

TEST(TrainLazy, NothingIsCopiedWhereNothingIsBehind) {
  const Scene scene = tiny_capture();
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  Observer silent;
  for (const char* idle : {"dense", "skip"}) {
    const TrainOptions options = idle_options(idle);
    Trainer trainer(*backend, scene, options, first_state(scene, options), silent);
    trainer.run(10);
    EXPECT_EQ(&trainer.host_model(), &trainer.state().model) << idle;
  }
}

}  // namespace
}  // namespace tessera
