// The mean of the parameters over the last steps of a training: alone, in the loop, and in a
// training that is resumed.
#include "recon4d/model/parameter_average.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "recon4d/options/presets.h"
#include "tests/support/resume.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

/// All values of a group of both sets, ascending: a finished model is in another order.
std::vector<float> sorted_values(const GaussianModel& model, Group group) {
  std::vector<float> values;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set}) {
    const Buffer<float>& value = set->group(group).value;
    values.insert(values.end(), value.begin(), value.end());
  }
  std::sort(values.begin(), values.end());
  return values;
}

TrainOptions averaging_options() {
  TrainOptions options = tiny_options();
  options.iterations = options.schedule_iterations = 28;
  options.densify_until = 0;
  options.reorder_interval = 0;
  options.average_from = 0.4;  // steps 15, 20 and 25, counted from 0
  return options;
}

// Bugs put back, seen to fail: the steps before average_from added, too; the mean not put in place.
TEST(ParameterAverage, TheModelIsTheMeanOfTheLastSteps) {
  const Scene scene = tiny_capture();
  TrainOptions plain = averaging_options();
  plain.average_from = 0;
  Training other(scene, plain);
  ParameterAverage average;
  TrainState mean;
  for (const int64_t steps : {16, 21, 26}) {
    mean = other.run(steps).state().clone_to(host_memory());
    std::swap(mean.average, average);
    add_to_average(other.backend(), mean);
    std::swap(mean.average, average);
  }
  EXPECT_EQ(average.states, 3);
  std::swap(mean.average, average);
  take_average(mean);
  EXPECT_EQ(mean.average.states, 0);
  other.run();
  Training training(scene, averaging_options());
  training.run();
  for (const Group group : {kMean, kOpacityLogit, kSh}) {
    const std::vector<float> now = sorted_values(training.model(), group);
    const std::vector<float> expected = sorted_values(mean.model, group);
    ASSERT_EQ(now.size(), expected.size());
    for (size_t i = 0; i < now.size(); ++i) ASSERT_NEAR(now[i], expected[i], 1e-5);
    EXPECT_NE(now, sorted_values(other.model(), group));
  }
}

TEST(ParameterAverage, OfOtherGaussiansBeginsAnew) {
  const Scene scene = tiny_capture();
  TrainOptions options = averaging_options();
  options.densify_from = 10;
  options.densify_until = 25;
  options.densify_interval = 3;
  Training training(scene, options);
  EXPECT_NO_THROW(training.run()) << "density control while parameters are averaged";
  TrainState state = training.state().clone_to(host_memory());
  add_to_average(training.backend(), state);
  state.average.begin_anew();
  const std::vector<float> before = sorted_values(state.model, kMean);
  take_average(state);
  EXPECT_EQ(sorted_values(state.model, kMean), before) << "of nothing the state stays";
}

// Bug put back: the mean is not in the checkpoint; seen to fail.
TEST(ParameterAverage, ResumesAtEachPlaceOfEachPreset) {
  Scene rig = tiny_capture(), photos = tiny_capture({.timesteps = 1, .moving = false});
  photos.is_static = true;
  for (const Scene* const scene : {&rig, &photos})
    for (const char* const preset : {"fast", "balanced", "best", "faster-gs", "3dgs", "mcmc"}) {
      TrainOptions options;
      apply_preset(options, preset, facts_of(*scene));
      options.iterations = 80;
      options.init_points = 60;
      options.init_extent = 1.2;
      options.densify_interval = 7;
      options.sweep = false;
      if (options.exposure == ExposureGains::kAuto) options.exposure = ExposureGains::kCamera;
      if (options.clocks == Clocks::kAuto) options.clocks = Clocks::kLearn;
      if (options.near_plane == 0) options.near_plane = 0.1;
      if (options.clear_distance < 0) options.clear_distance = 0.5;
      Training whole(*scene, options);
      whole.run();
      const bool averages = options.average_from > 0;
      for (const int64_t stop : {40, 71, 77}) {
        SCOPED_TRACE(std::string(preset) + " of a " + (scene == &rig ? "rig" : "place") +
                     ", step " + std::to_string(stop));
        expect_resumes(*scene, options, stop, whole, [&](const TrainState& state) {
          EXPECT_EQ(state.average.states > 0, averages && stop > 70);
        });
      }
    }
}

}  // namespace
}  // namespace tessera::testing
