// An object that moves, rests for most of the clip, and moves again. Source: failure mode A5.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ingest/cloud/dense_cloud.h"
#include "static3d/transform/slicer.h"
#include "tests/recon4d/modes/modes_film.h"

namespace tessera::testing {
namespace {

constexpr double kMoves = 0.1;  // clip lengths at either end: one second of ten
constexpr int kMoments = 51;

/// A ball moves 16 pixels in the first second and as far in the last, over a shelf.
Film resting_film() {
  Film film;
  film.timesteps = kMoments;
  film.world = [unit = film.pixels_a_unit()](double time) {
    const double coming = std::min(0.0, (time - kMoves) / kMoves);
    const double going = std::max(0.0, (time - (1 - kMoves)) / kMoves);
    synth::World world = even_world();
    add_solid(world, synth::ShapeKind::kSphere, glm::dvec3(0.3),
              {16 * (coming + going) / unit, 0, 0.25}, warm(0.12));
    add_solid(world, synth::ShapeKind::kBox, {1, 0.3, 0.15}, {0, 0, -0.5}, cold(0.15), false);
    return world;
  };
  return film;
}

/// Counts Gaussians with a short temporal extent (marginal of at least a half, 2.355 σ_t).
int short_lives_in_the_rest(const GaussianModel& model) {
  constexpr double kLife = 2.3548, kFrame = 1.0 / (kMoments - 1);
  int count = 0;
  const Slicer slicer(model);
  for (const MovingGaussian& g : slicer.moving()) {
    const double life = kLife / std::sqrt(double(g.spacetime.precision_time));
    const double mean_time = g.spacetime.mean_time;
    count += life < kMoves && mean_time > kMoves + kFrame && mean_time < 1 - kMoves - kFrame;
  }
  return count;
}

/// Mean over pixels of the standard deviation over the timesteps of the rest, 8-bit steps.
double unrest(const std::vector<RenderedImage>& images) {
  constexpr int kFirst = 7, kEnd = 44;
  const std::vector<double> deviation =
      deviation_over_time({images.begin() + kFirst, images.begin() + kEnd});
  return std::accumulate(deviation.begin(), deviation.end(), 0.0) / double(deviation.size());
}

// What rests for most of the clip becomes static. The row demands no variance in the rest; 0.08 of
// a step is seen, 0.17 without decisions: dynamic Gaussians fade in and out, and their marginals
// never reach zero. Bug put back: temporal extents start at a hundredth of the clip and no Gaussian
// becomes static; seen to fail by short extents in the rest.
TEST(LongRest, IsHeldByLongExtents) {
  const Film film = resting_film();
  Scene scene = shoot(film);
  scene.points = surface_cloud(film, 200, 400);
  const GaussianModel model = decided(scene, short_training("balanced", 700));
  EXPECT_GT(model.dynamic_set.count(), 20);
  EXPECT_LT(model.dynamic_set.count(), model.static_set.count() / 4) << "a fifth of the clip moves";
  EXPECT_EQ(short_lives_in_the_rest(model), 0);
  EXPECT_LT(unrest(middle_images(model, scene)), 0.1);
  EXPECT_GT(middle_psnr(model, scene), 28);
}

// Bug put back: the last eighth of the clip ignored; seen to fail by 50 of 79 points.
TEST(LongRest, WhatLeavesAtTheEndIsNotStill) {
  Film film;
  film.timesteps = kMoments;
  film.world = [unit = film.pixels_a_unit()](double time) {
    const double going = std::max(0.0, (time - (1 - kMoves)) / kMoves);
    synth::World world = even_world();
    add_solid(world, synth::ShapeKind::kSphere, glm::dvec3(0.3), {16 * going / unit, 0, 0.25},
              warm(0.12));
    add_solid(world, synth::ShapeKind::kBox, {1, 0.3, 0.15}, {0, 0, -0.5}, cold(0.15), false);
    return world;
  };
  CloudOptions options;
  options.points = 400;
  const Scene scene = shoot(film);
  const PointCloud cloud = cloud_of(dense_points(PlaneSweep(scene), options));
  int ball = 0, still = 0;
  for (size_t i = 0; i < cloud.position.size(); ++i)
    if (cloud.position[i].z > 0) {
      ++ball;
      still += cloud.still[i] == 1;
    }
  EXPECT_GT(ball, 30);
  EXPECT_LT(still, ball / 10) << "where the ball looks alike";
}

}  // namespace
}  // namespace tessera::testing
