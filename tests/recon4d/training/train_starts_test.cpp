// Trainings with a poor start: from the points of the first timestep, without points, with few
// cameras. Source: failure modes B11, B12.
#include <gtest/gtest.h>

#include <cmath>

#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/render.h"
#include "tests/support/random.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

/// The tiny truth, with its second moving blob only in the second half of the clip.
GaussianModel late_truth(const TinyCapture& capture) {
  GaussianModel truth = tiny_truth(capture);
  const GaussianSpans<float> v = truth.dynamic_set.values();
  *v.at(kMeanTime, 1) = 1;
  *v.at(kLogScaleTime, 1) = std::log(0.12f);
  return truth;
}

/// `count` points inside the Gaussians of `truth` at each of the times, coloured.
PointCloud points_of(const GaussianModel& truth, const std::vector<double>& times, int count) {
  PointCloud cloud;
  Random random(3);
  for (const double t : times)
    for (const GaussianSet* set : {&truth.static_set, &truth.dynamic_set})
      for (int64_t n = 0; n < set->count(); ++n) {
        const GaussianSpans<const float> v = set->values();
        if (set->dim() == 4 &&
            std::abs(t - *v.at(kMeanTime, n)) > 2 * std::exp(*v.at(kLogScaleTime, n)))
          continue;
        for (int i = 0; i < count; ++i) {
          glm::vec3 p;
          for (int k = 0; k < 3; ++k)
            p[k] =
                v.at(kMean, n)[k] + float(random.uniform(-1, 1)) * std::exp(v.at(kLogScale, n)[k]);
          cloud.position.push_back(p);
          cloud.time.push_back(float(t));
          std::array<uint8_t, 3> colour;
          for (int k = 0; k < 3; ++k)
            colour[size_t(k)] = uint8_t(255 * (0.5 + kSh0 * v.at(kSh, n)[k]));
          cloud.colour.push_back(colour);
        }
      }
  return cloud;
}

TrainOptions short_training(int64_t iterations) {
  TrainOptions options = tiny_options();
  options.iterations = options.schedule_iterations = iterations;
  options.densify_until = 2 * iterations / 3;
  options.densify_interval = 20;
  options.densify_from = 40;
  options.init_points = 120;
  options.static_fraction = 0.3;
  return options;
}

/// Mean PSNR of the model over frames, dB, un-quantised.
double psnr_of(const std::vector<Frame>& frames, const GaussianModel& model) {
  std::vector<View> views;
  for (const Frame& frame : frames) views.push_back({frame.camera, frame.time});
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  const std::vector<RenderedImage> images = render_views(*backend, model, views);
  double sum = 0;
  for (size_t i = 0; i < images.size(); ++i) sum += psnr_float(images[i].planar(), frames[i].image);
  return sum / double(frames.size());
}

/// Of the scene's frames after a short training that starts from `points`.
double psnr_from(Scene scene, const PointCloud& points) {
  scene.points = points;
  Training training(scene, short_training(200));
  return training.run().psnr();
}

// B11: points of all timesteps ≥ of the first timestep > at random; what appears late costs the
// second its place. Bug put back: points of later timesteps are dropped; seen to fail.
TEST(TrainStarts, PointsOfAllTimestepsBeatTheFirstAndThatBeatsNone) {
  TinyCapture capture{.timesteps = 6};
  const GaussianModel truth = late_truth(capture);
  const Scene scene = tiny_capture(capture, truth);
  const double random = psnr_from(scene, {});
  const double first = psnr_from(scene, points_of(truth, {0}, 30));
  const double all = psnr_from(scene, points_of(truth, {0, 0.2, 0.4, 0.6, 0.8, 1}, 5));
  EXPECT_GT(first, random + 3);  // 25.2, 31.2 and 31.8 dB were seen
  EXPECT_GT(all, first + 0.2);
}

// B12: a held-out camera by the number of cameras that were trained on; three seeds each.
// Bug put back: frames of the first two cameras alone are drawn; seen to fail.
TEST(TrainStarts, MoreCamerasAreBetterAndTwoAreEnoughToFinish) {
  TinyCapture capture{.cameras = 17, .size = 24};
  const Scene full = tiny_capture(capture);
  const auto last = full.frames.end() - capture.timesteps;
  const std::vector<Frame> held_out(last, full.frames.end());
  double of_two = 0, before = 0;
  for (const int cameras : {2, 4, 8, 16}) {
    Scene scene = full;
    scene.frames.clear();
    for (auto frame = full.frames.begin(); frame != last; ++frame)
      if ((frame - full.frames.begin()) / capture.timesteps % (16 / cameras) == 0)
        scene.frames.push_back(*frame);
    double sum = 0;
    for (int seed = 0; seed < 3; ++seed) {
      TrainOptions options = short_training(300);
      options.seed = seed;
      Training training(scene, options);
      sum += psnr_of(held_out, training.run().model()) / 3;
    }
    // 24.9, 27.8, 28.4 and 28.3 dB are the means of ten seeds, of which one strays by 1 to 2 dB
    EXPECT_GT(sum, before - 0.5) << cameras;
    if (cameras == 2)
      of_two = sum;
    else
      EXPECT_GT(sum, of_two + 1) << cameras;
    before = sum;
  }
}

}  // namespace
}  // namespace tessera::testing
