// The highest speed at which an object is still reconstructed in its place. Source: failure mode
// A4.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/recon4d/modes/modes_film.h"

namespace tessera::testing {
namespace {

/// There and back between 0 and `span` with unit speed.
double zigzag(double way, double span) {
  const double position = std::fmod(way, 2 * span);
  return position < span ? position : 2 * span - position;
}

/// A ball of 20 pixels that moves to and fro over 68 pixels, `speed` pixels a frame.
Film ball_film(double speed) {
  Film film;
  film.width = 96;
  film.height = 48;
  film.world = [speed, last = film.timesteps - 1, unit = film.pixels_a_unit()](double time) {
    synth::World world = even_world();
    const double x = zigzag(speed * time * last, 68) - 34;
    add_solid(world, synth::ShapeKind::kSphere, glm::dvec3(0.26), {x / unit, 0, 0.1}, warm(0.12));
    return world;
  };
  return film;
}

/// Largest distance of the centroids of render and truth in the held-out camera, pixels.
double worst_error(double speed, TrainOptions options) {
  const Film film = ball_film(speed);
  Scene scene = shoot(film);
  scene.points = surface_cloud(film, 0, 400);
  const std::vector<RenderedImage> images = middle_images(trained(scene, options), scene);
  const std::vector<const Frame*> frames = held_out(scene);
  double worst = 0;
  for (size_t i = 0; i < images.size(); ++i) {
    const auto drawn = centroid(images[i]), truth = centroid(image_of(frames[i]->image));
    worst = std::max(worst, std::hypot(drawn[0] - truth[0], drawn[1] - truth[1]));
  }
  return worst;
}

// The stated limit of the preset as it is: 4 pixels a frame, a fifth of the ball; the worst error
// is below one pixel, where 500 steps have 1.0. Falls short of the row at 16 and 64 pixels a frame:
// 45 and 74 px, at 16 also after 4,000 steps: Gaussians that start with an extent of half the clip
// are wrong in most frames and fade out before their extent is short. Bug put back: velocities stay
// 0; seen to fail by 2.8 px.
TEST(FastMotion, BalancedFollowsAFifthOfTheSizeAFrame) {
  for (const double speed : {1.0, 4.0})
    EXPECT_LT(worst_error(speed, short_training("balanced", 700)), 1) << speed << " px/frame";
}

// Where temporal extents start at the time between two frames, all speeds up to 64 px a frame work:
// 0.36 and 0.27 px.
// Bug put back: init_time_scale not read; seen to fail by 45 and 74 px.
TEST(FastMotion, ExtentsOfAFrameFollowAnySpeed) {
  TrainOptions options = short_training("balanced", 500);
  options.init_time_scale = 0.06;
  for (const double speed : {16.0, 64.0})
    EXPECT_LT(worst_error(speed, options), 1) << speed << " px/frame";
}

}  // namespace
}  // namespace tessera::testing
