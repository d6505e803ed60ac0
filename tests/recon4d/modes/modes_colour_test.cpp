// A surface that does not move and changes only its colour. Source: failure mode A17.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ingest/cloud/dense_cloud.h"
#include "kernels/base/median.h"
#include "tests/recon4d/modes/modes_film.h"

namespace tessera::testing {
namespace {

/// An image on a wall in light that grows evenly over the clip; `wide` 0.6 fills a fifth of the
/// view.
Film lamp_film(double from, double to, double wide = 1) {
  Film film;
  film.timesteps = 21;
  film.world = [from, to, wide](double time) {
    synth::World world = even_world();
    add_solid(world, synth::ShapeKind::kQuad, wide * glm::dvec3(0.7, 0.6, 0), {0, 0, 0},
              warm(0.15, from + (to - from) * time));
    return world;
  };
  return film;
}

/// Mean of a channel inside the quad, 8-bit steps.
double level(const RenderedImage& image, int channel) {
  constexpr int kFirst = 20, kEnd = 44;  // of 64 pixels, both ways
  double sum = 0;
  for (int y = kFirst; y < kEnd; ++y)
    for (int x = kFirst; x < kEnd; ++x)
      sum += image.rgb[size_t((channel * image.height + y) * image.width + x)];
  return 255 * sum / ((kEnd - kFirst) * (kEnd - kFirst));
}

// Light that grows by three quarters, and by a seventh, which hardly changes the contrast, on a
// part of the view. Bug put back: brightness ignored; seen to fail.
TEST(ColourChange, IsNotStill) {
  for (const double from : {0.25, 0.85}) {
    const Scene scene = shoot(lamp_film(from, 1, 0.6));
    CloudOptions options;
    options.points = 400;
    const PointCloud cloud = cloud_of(dense_points(PlaneSweep(scene), options));
    ASSERT_GT(cloud.still.size(), 100u);
    int64_t still = 0;
    for (size_t i = 0; i < cloud.still.size(); ++i)
      still += cloud.still[i] == 1 && cloud.colour[i][0] > 60;  // not of the dark around it
    EXPECT_LT(still, int64_t(cloud.still.size()) / 50) << from;
  }
}

// Medians of five seeds. Falls short of the row at single timesteps: the worst of the channels is
// 1.4 to 2.7 steps off, where the row has 1. Not for varying last steps: with learning rates that
// fall to 0 over the last tenth to four tenths it is 1.5 to 2.3. Bug put back: all points static;
// seen to fail by 58 steps.
TEST(ColourChange, IsRecovered) {
  const Film film = lamp_film(0.25, 1);
  Scene scene = shoot(film);
  scene.points = surface_cloud(film, 0, 400);
  const std::vector<const Frame*> frames = held_out(scene);
  TrainOptions options = short_training("balanced", 500);
  std::vector<double> means, worsts;  // over timesteps, of the worst channel
  for (options.seed = 1; options.seed <= 5; ++options.seed) {
    const std::vector<RenderedImage> images = middle_images(trained(scene, options), scene);
    double mean = 0, worst = 0;
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (size_t m = 0; m < images.size(); ++m) {
        const double off = std::abs(level(images[m], c) - level(image_of(frames[m]->image), c));
        sum += off;
        worst = std::max(worst, off);
      }
      mean = std::max(mean, sum / double(images.size()));
    }
    means.push_back(mean);
    worsts.push_back(worst);
  }
  EXPECT_LT(median(means), 1);
  EXPECT_LT(median(worsts), 2.5);
}

}  // namespace
}  // namespace tessera::testing
