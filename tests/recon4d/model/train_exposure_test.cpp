// Gains of cameras and of images learnt in a training: recovered, with a fixed gauge, kept by a
// checkpoint, refused where they have no meaning. Source: failure mode B10.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "recon4d/model/exposure.h"
#include "tests/recon4d/model/exposed_training.h"
#include "tests/support/random.h"
#include "tests/support/resume.h"
#include "tests/support/separate_backend.h"

namespace tessera::testing {
namespace {

using Gains = std::vector<Vec3<double>>;

/// [R] RGB.
Gains learnt_gains(const LearntRows& state) {
  Gains gains;
  for (const ColourMap<double>& map : colour_maps_of(state)) gains.push_back(channel_response(map));
  return gains;
}

/// Every image times the gain of its row, of images darkened so that none is clipped.
Scene gained(const TinyCapture& capture, const Gains& gains, bool by_camera) {
  Scene scene = tiny_capture(capture);
  for (size_t f = 0; f < scene.frames.size(); ++f) {
    const Vec3<double>& gain = gains[by_camera ? f / size_t(capture.timesteps) : f];
    std::vector<uint8_t>& bytes = scene.frames[f].image.data;
    for (size_t i = 0; i < bytes.size(); ++i)
      bytes[i] = uint8_t(std::lround(0.7 * gain[int(i % 3)] * bytes[i]));
  }
  return scene;
}

Vec3<double> mean_of(const Gains& gains) {
  Vec3<double> sum(0);
  for (const Vec3<double>& gain : gains) sum += gain;
  return sum / double(gains.size());
}

/// In either order, and as floats.
void expect_mean_of_one(const Gains& gains) {
  for (int c = 0; c < 3; ++c) {
    double forward = 0, backward = 0;
    for (size_t r = 0; r < gains.size(); ++r) {
      EXPECT_EQ(double(float(gains[r][c])), gains[r][c]);
      forward += gains[r][c];
      backward += gains[gains.size() - 1 - r][c];
    }
    EXPECT_EQ(forward / double(gains.size()), 1.0);
    EXPECT_EQ(backward, forward);
  }
}

// B10. One camera is (1.2, 1.0, 0.9) of the others. The gains are that by the mean of all, and the
// Gaussians have the colours of the unmodified images times that mean.
// Bugs put back, each seen to fail: gauge not fixed; gains of the next view; the gain left out of
// the loss; what rounding leaves not spread.
TEST(TrainExposure, OneCameraThatDiffersIsFoundAndColoursAreLeft) {
  const TinyCapture capture = exposed_ring();
  Gains truth(5, Vec3<double>(1));
  const Scene plain = gained(capture, truth, true);
  truth[2] = {1.2, 1.0, 0.9};
  const Scene scene = gained(capture, truth, true);
  TrainOptions options = still_options(900);
  Training usual(plain, options, dimmed_truth(capture, 1));
  const std::vector<double> expected = colours_of(usual.run().model());
  options.exposure = ExposureGains::kCamera;
  Training training(scene, options, dimmed_truth(capture, 1));
  training.run();
  const Gains gains = learnt_gains(training.state().exposure);
  ASSERT_EQ(gains.size(), 5u);
  expect_mean_of_one(gains);
  const Vec3<double> mean = mean_of(truth);
  for (size_t r = 0; r < 5; ++r)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(gains[r][c] * mean[c] / truth[r][c], 1, 0.01) << r << ", " << c;
  const std::vector<double> found = colours_of(training.model());
  for (size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i] / mean[int(i % 3)], expected[i], 1.0 / 255) << i;
}

// B10. Bug put back: rows of cameras for those of frames; seen to fail.
TEST(TrainExposure, WobbleOfEveryImageIsFound) {
  TinyCapture capture = exposed_ring();
  capture.moving = false;  // five images a timestep: temporal extents would explain a wobble
  Random random(5);
  Gains truth;
  for (int f = 0; f < capture.cameras * capture.timesteps; ++f)
    truth.emplace_back(random.uniform(0.99, 1.01), random.uniform(0.99, 1.01),
                       random.uniform(0.99, 1.01));
  const Scene scene = gained(capture, truth, false);
  TrainOptions options = still_options(900);
  options.exposure = ExposureGains::kFrame;
  options.lr_sh = 5e-4;
  Training training(scene, options, dimmed_truth(capture, 0.75));
  training.run();
  const Gains gains = learnt_gains(training.state().exposure);
  ASSERT_EQ(gains.size(), truth.size());
  expect_mean_of_one(gains);
  const Vec3<double> mean = mean_of(truth);
  double left = 0, wobble = 0;
  for (size_t r = 0; r < truth.size(); ++r)
    for (int c = 0; c < 3; ++c) {
      wobble += std::pow(truth[r][c] / mean[c] - 1, 2);
      left += std::pow(gains[r][c] * mean[c] / truth[r][c] - 1, 2);
    }
  EXPECT_LT(std::sqrt(left), 0.3 * std::sqrt(wobble));  // images are rounded to 8 bits
}

// E5. Bug put back: moments not in the checkpoint; seen to fail.
TEST(TrainExposure, ResumeIsBitEqual) {
  const Scene scene = tiny_capture();
  for (const ExposureGains by : {ExposureGains::kCamera, ExposureGains::kFrame}) {
    TrainOptions options = tiny_options();
    options.exposure = by;
    Training whole(scene, options);
    whole.run();
    expect_resumes(scene, options, 21, whole,
                   [](const TrainState& state) { EXPECT_GT(state.exposure.rows(), 0); });
  }
}

// Bug put back: gains kept in the backend's memory; seen to fail.
TEST(TrainExposure, IsTheSameInASeparateMemory) {
  const Scene scene = tiny_capture();
  TrainOptions options = tiny_options();
  options.exposure = ExposureGains::kCamera;
  Training here(scene, options);
  here.run();
  SeparateBackend separate;
  Training separate_training(scene, options, first_state(scene, options), separate);
  separate_training.run();
  const Buffer<float>&one = here.state().exposure.value,
        &other = separate_training.state().exposure.value;
  EXPECT_TRUE(std::equal(one.begin(), one.end(), other.begin(), other.end()));
}

// A gain far from the others' meets its limit before the gauge loses a bit.
// Bug put back: no limit; seen to fail.
TEST(TrainExposure, MeanIsOneWhateverIsLearnt) {
  LearntRows state;
  state.reset(301, 3);
  Random random(6);
  for (int round = 0; round < 5; ++round) {
    std::vector<int32_t> rows;
    std::vector<ColourMap<double>> d_maps;
    for (int i = 0; i < 40; ++i) {
      rows.push_back(int32_t(random.below(301)));
      d_maps.push_back(colour_gain<double>({random.uniform(-1, 1), i % 2 ? -1e9 : 1e9, 1e-12}));
    }
    step_exposure(rows, d_maps, 2, state);
    expect_mean_of_one(learnt_gains(state));
  }
}

// Adam by hand for the one row that is seen, whose log gain is measured by its distance to the
// other's: the gauge moves both alike. Bugs put back, each seen to fail: t counted from 0; from 2.
TEST(TrainExposure, StepsAreAdams) {
  constexpr double kRate = 0.01;
  LearntRows state;
  state.reset(2, 3);
  step_exposure({1}, {colour_gain(Vec3<double>(0.1))}, kRate,
                state);  // the other row's own first step
  const double start = double(state.value[0]) - double(state.value[3]);
  double m = 0, v = 0, expected = 0;
  const double d_gains[] = {0.3, -0.7, 0.05};
  for (int t = 1; t <= 3; ++t) {
    const double g = learnt_gains(state)[0][0] * d_gains[t - 1];
    m = 0.9 * m + 0.1 * g;
    v = 0.999 * v + 0.001 * g * g;
    expected -= kRate * (m / (1 - std::pow(0.9, t))) / std::sqrt(v / (1 - std::pow(0.999, t)));
    step_exposure({0}, {colour_gain<double>({d_gains[t - 1], 0, 0})}, kRate, state);
    EXPECT_NEAR(state.value[0] - state.value[3] - start, expected, 1e-5) << t;
  }
}

void expect_refused(const Scene& scene, ExposureGains by, const std::vector<std::string>& parts) {
  TrainOptions options = tiny_options();
  options.exposure = by;
  try {
    Training training(scene, options);
    ADD_FAILURE() << "was not refused";
  } catch (const InputError& error) {
    for (const std::string& part : parts)
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

// Bugs put back, each seen to fail: a single camera taken; a white background taken.
TEST(TrainExposure, IsRefusedWhereItMeansNothing) {
  TinyCapture capture{.cameras = 1};
  expect_refused(tiny_capture(capture), ExposureGains::kCamera,
                 {"4 training frames", "ring0", "frame"});
  expect_refused(tiny_capture(capture), ExposureGains::kAffine,
                 {"4 training frames", "one camera, 'ring0'", "--exposure frame"});
  capture.timesteps = 1;
  expect_refused(tiny_capture(capture), ExposureGains::kFrame, {"--exposure none"});
  capture.cameras = 3;
  capture.background = {255, 255, 255};
  expect_refused(tiny_capture(capture), ExposureGains::kCamera, {"background"});
}

// Bug put back: names of frames; seen to fail.
TEST(TrainExposure, JsonNamesTheCameras) {
  const Scene scene = tiny_capture();
  TrainOptions options = tiny_options();
  options.exposure = ExposureGains::kCamera;
  const ExposureRows rows = exposure_rows(scene, scene.split_indices(Split::kTrain), options);
  LearntRows state;
  state.reset(int64_t(rows.names.size()), 3);
  const nlohmann::json json = exposure_json(rows, state, options);
  EXPECT_EQ(json["by"], "camera");
  EXPECT_EQ(json["gains"].size(), 6u);
  EXPECT_EQ(json["gains"]["ring3"], nlohmann::json({1.0, 1.0, 1.0}));
}

// Bugs put back, each seen to fail: gains stored as they are, not their logarithms; a matrix that
// is transposed. Finds also: a camera that is not there taken for 1.
TEST(Exposure, ComesBackFromItsJson) {
  for (const ExposureGains kind : {ExposureGains::kCamera, ExposureGains::kAffine}) {
    TrainOptions options;
    options.exposure = kind;
    LearntRows state;
    state.reset(3, exposure_width(kind));
    Random random(3);
    for (float& value : state.value) value = float(random.uniform(-0.2, 0.2));
    ExposureRows rows{{}, {"a", "b", "c"}};
    const nlohmann::json json = exposure_json(rows, state, options);
    rows.names = {"c", "a", "b"};
    const auto maps = colour_maps_of(state),
               back = colour_maps_of(exposure_of_json(json, rows, options, "exposure.json"));
    for (size_t r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(back[(r + 1) % 3].offset[c], maps[r].offset[c], 1e-5);
        for (int d = 0; d < 3; ++d)
          EXPECT_NEAR(back[(r + 1) % 3].matrix[c][d], maps[r].matrix[c][d], 1e-5);
      }
    rows.names = {"a", "d"};
    EXPECT_THROW(exposure_of_json(json, rows, options, "exposure.json"), InputError);
  }
}

}  // namespace
}  // namespace tessera::testing
