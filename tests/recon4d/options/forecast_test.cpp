// Forecasts of memory and time in 64 bits. Their accuracy was measured on trainings
// (research/results_history.md).
#include "recon4d/options/forecast.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "kernels/base/errors.h"
#include "recon4d/options/presets.h"

namespace tessera::testing {
namespace {

// 10^5 frames of 4K: 2.5e12 bytes. Fails with any product in 32 bits.
TEST(Forecast, DoesNotOverflow) {
  ForecastLoad load;
  load.training_frames = 100000, load.pixels = int64_t{3840} * 2160;
  load.image_bytes = load.training_bytes = 3 * load.training_frames * load.pixels;
  load.rig = true;
  TrainOptions options;
  options.max_gaussians = 100000000;
  options.batch = 64;
  const TrainForecast forecast = forecast_training(load, options);
  EXPECT_EQ(forecast.frame_bytes, 2488320000000);
  EXPECT_EQ(forecast.parameter_bytes,
            100000000LL * 4 * (3 * 17 + 2 * 48));  // 59 + 1 + 1 + 4 floats
  EXPECT_EQ(forecast.step_bytes, 64 * load.pixels * 68 + 2560000000LL * 168 +
                                     forecast.parameter_bytes + 100000000LL * 4 * (17 + 48));
  EXPECT_GT(forecast.total_bytes,
            forecast.frame_bytes + forecast.parameter_bytes + forecast.step_bytes);
  EXPECT_GT(forecast.cpu_seconds, forecast.gpu_seconds);
}

/// As dnerf_lego's.
ForecastLoad frames_of_800(int threads) {
  constexpr int64_t kPixels = 800 * 800, kBytes = 50 * 3 * kPixels;
  return {.training_frames = 50,
          .pixels = kPixels,
          .image_bytes = kBytes,
          .training_bytes = kBytes,
          .threads = threads};
}

// Bugs put back: nodes counted as pairs; no time for the trials; each seen to fail.
TEST(Forecast, CountsMotionNodesAndTheirTrials) {
  const ForecastLoad load = frames_of_800(2);
  TrainOptions options;
  options.max_gaussians = 1000;
  options.motion = Motion::kNodes;
  // 11 + 8 trained scalars with moments, 8 numbers of nodes, and colours
  const TrainForecast nodes = forecast_training(load, options);
  EXPECT_EQ(nodes.parameter_bytes, nodes.gaussians * 4 * (3 * (11 + 8) + 8 + 2 * 48));
  options.motion = Motion::kPair;
  const TrainForecast pair = forecast_training(load, options);
  EXPECT_GT(nodes.step_bytes, pair.step_bytes);
  options.motion = Motion::kAuto;
  const double three = forecast_training(load, options).cpu_seconds - pair.cpu_seconds;
  options.motion_nodes = 16;  // stated, so that no third trial tells it
  const double two = forecast_training(load, options).cpu_seconds - pair.cpu_seconds;
  options.motion = Motion::kPair;
  options.iterations = 2 * kTrialIterations;
  ForecastLoad small = load;
  small.pixels = kTrialPixels;
  EXPECT_NEAR(two, forecast_training(small, options).cpu_seconds, 1e-6 * two);
  EXPECT_NEAR(three, 1.5 * two, 1e-6 * three);
}

// Bug put back: Gaussians of a still scene counted with motion; seen to fail.
TEST(Forecast, WhatStandsStillHasNoMotion) {
  ForecastLoad load = frames_of_800(2);
  TrainOptions options;
  options.motion = Motion::kAuto;
  const TrainForecast moving = forecast_training(load, options);
  load.still = true;
  const TrainForecast still = forecast_training(load, options);
  EXPECT_LT(still.parameter_bytes, moving.parameter_bytes);
  EXPECT_LT(still.gpu_seconds, moving.gpu_seconds);
}

// research/results_history.md: the run of `synth room`, preset fast, took 138.1 s on 2 threads;
// dnerf_lego 67.2 s on an H200; research/long_captures.md: the steps of a window of 20 cameras
// 27.3 s. The model claims a factor of 3. Bug put back: a pixel of a rig as one of an object before
// nothing; seen to fail.
TEST(Forecast, IsNearMeasuredRuns) {
  TrainOptions fast;
  apply_preset(fast, "fast");
  ForecastLoad room;
  room.training_frames = 264;
  room.pixels = 240 * 180;
  room.rig = true;
  room.threads = 2;
  EXPECT_NEAR(std::log(forecast_training(room, fast).cpu_seconds / 138.1), 0, std::log(3));
  TrainOptions yang;
  apply_preset(yang, "faster-gs");
  EXPECT_NEAR(std::log(forecast_training(frames_of_800(2), yang).gpu_seconds / 67.2), 0,
              std::log(3));
  TrainOptions balanced;
  apply_preset(balanced, "balanced",
               {.camera_pixels = 19 * 1352 * 1014, .cameras = 19, .timesteps = 166});
  ForecastLoad window;
  window.training_frames = 19 * 166;
  window.pixels = 1352 * 1014;
  window.rig = true;
  EXPECT_NEAR(std::log(forecast_training(window, balanced).gpu_seconds / 27.3), 0, std::log(1.5));
}

/// Three cameras of 10 × 4 pixels at five timesteps, one of them held out; the others share masks,
/// one by camera, and the last of them moves.
Scene rig_with_masks() {
  Scene scene;
  const FrameMask masks[] = {{}, Image8{10, 4, 1, {}}, Image8{10, 4, 1, {}}};
  for (int k = 0; k < 3; ++k)
    for (int t = 0; t < 5; ++t) {
      Frame& frame = scene.frames.emplace_back();
      frame.camera_name = "cam" + std::to_string(k);
      frame.split = k == 0 ? Split::kTest : Split::kTrain;
      frame.timestep = t;
      frame.camera.width = 10;
      frame.camera.height = 4;
      frame.camera.translation = {double(k), k == 2 ? double(t) : 0, 0};
      frame.mask = masks[k];
    }
  return scene;
}

// Bugs put back, each seen to fail: test frames left out; a mask counted for each frame; no masks
// of moving pixels; those of a camera that moves counted.
TEST(Forecast, CountsAllSplitsAndMasks) {
  const ForecastLoad load = forecast_load(rig_with_masks());
  EXPECT_EQ(load.training_frames, 10);
  EXPECT_EQ(load.image_bytes, 15 * 120);
  EXPECT_EQ(load.mask_bytes, 2 * 40);
  EXPECT_EQ(load.training_bytes, 10 * 120);
  EXPECT_EQ(load.training_mask_bytes, 2 * 40);
  EXPECT_EQ(load.moving_mask_bytes, 5 * 40 + 40);
  EXPECT_TRUE(load.rig);
  TrainOptions options;
  const TrainForecast plain = forecast_training(load, options);
  EXPECT_EQ(plain.frame_bytes, 15 * 120 + 2 * 40);
  EXPECT_EQ(plain.device_frame_bytes, 10 * 120 + 2 * 40);
  options.moving_weight = 4;
  const TrainForecast weighed = forecast_training(load, options);
  EXPECT_EQ(weighed.frame_bytes, 15 * 120 + 2 * 40 + 5 * 40 + 40);
  EXPECT_EQ(weighed.device_frame_bytes, 10 * 120 + 5 * 40 + 40);
  ForecastLoad large = load;  // bug put back: what scoring takes is not counted; seen to fail
  large.pixels = 100000000;
  EXPECT_GT(forecast_training(large, options).host_bytes, 100 * large.pixels);
}

// Bugs put back, each seen to fail: none is refused; test views counted that are not read; masks of
// what moves counted that are not made. Finds also: a scene refused that fits; the remedy not
// named.
TEST(Forecast, RefusesASceneThatDoesNotFit) {
  Scene scene;
  scene.path = "long";
  for (int i = 0; i < 100; ++i) {
    Frame frame;
    frame.camera_name = "cam";
    frame.timestep = i;
    frame.camera.width = frame.camera.height = 100;
    if (i % 4 == 0) frame.split = Split::kTest;
    scene.frames.push_back(std::move(frame));
  }
  const ForecastLoad load = forecast_load(scene);
  const int64_t bytes = load.image_bytes + load.mask_bytes + load.moving_mask_bytes;
  EXPECT_GE(bytes, 100 * 30000);
  EXPECT_NO_THROW(check_fits_memory(scene, {}, bytes * 10 / 9 + 2));
  EXPECT_NO_THROW(check_fits_memory(scene, {.held_out = false}, bytes * 9 / 10));
  EXPECT_NO_THROW(check_fits_memory(scene, {.moving_masks = false}, bytes));
  try {
    check_fits_memory(scene, {}, bytes * 10 / 9 - 2);
    FAIL() << "is accepted";
  } catch (const InputError& error) {
    const std::string message = error.what();
    for (const char* part : {"long: ", "GB", "--windows auto", "--scale"})
      EXPECT_NE(message.find(part), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace tessera::testing
