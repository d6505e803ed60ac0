// What: a surface that stays and changes its colour alone.
// Not: moving surfaces. Source: failure mode A17.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ingest/dense_cloud.h"
#include "tests/recon4d/modes_film.h"

namespace tessera::testing {
namespace {

/// A picture on a wall in light that grows evenly over the clip.
Film lamp_film(double from, double to) {
  Film film;
  film.moments = 21;
  film.world = [from, to](double time) {
    synth::World world = even_world();
    add_solid(world, synth::ShapeKind::kQuad, {0.7, 0.6, 0}, {0, 0, 0},
              warm(0.15, from + (to - from) * time));
    return world;
  };
  return film;
}

/// Mean of a channel inside the quad, 8-bit steps.
double level(const Picture& picture, int channel) {
  constexpr int kFirst = 20, kEnd = 44;  // of 64 pixels, both ways
  double sum = 0;
  for (int y = kFirst; y < kEnd; ++y)
    for (int x = kFirst; x < kEnd; ++x)
      sum += picture.rgb[size_t((channel * picture.height + y) * picture.width + x)];
  return 255 * sum / ((kEnd - kFirst) * (kEnd - kFirst));
}

TEST(ColourChange, IsNotStill) {
  Scene scene = shoot(lamp_film(0.25, 1));
  CloudOptions options;
  options.points = 400;
  scene.points = dense_cloud(scene, options);
  ASSERT_GT(scene.points.still.size(), 100u);
  EXPECT_LT(std::count(scene.points.still.begin(), scene.points.still.end(), 1),
            int64_t(scene.points.still.size()) / 50);
}

TEST(ColourChange, IsRecovered) {
  const Film film = lamp_film(0.25, 1);
  Scene scene = shoot(film);
  scene.points = surface_cloud(film, 0, 400);
  const std::vector<Picture> pictures =
      middle_pictures(trained(scene, short_training("balanced", 500)), scene);
  const std::vector<const Frame*> frames = held_out(scene);
  for (size_t m = 0; m < pictures.size(); ++m)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(level(pictures[m], c), level(picture_of(frames[m]->image), c), 1) << m;
}

}  // namespace
}  // namespace tessera::testing
