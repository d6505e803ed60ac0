// What: a thing that moves, rests for most of the clip, and moves again.
// Not: what never moves (slice_test.cpp). Source: failure mode A5.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ingest/dense_cloud.h"
#include "static3d/slicer.h"
#include "tests/recon4d/modes_film.h"

namespace tessera::testing {
namespace {

constexpr double kMoves = 0.1;  // clip lengths at either end: one second of ten
constexpr int kMoments = 51;

/// A ball comes 16 pixels in the first second and goes as far in the last, over a shelf.
Film resting_film() {
  Film film;
  film.moments = kMoments;
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

/// Lives: where the marginal is at least a half, 2.355 σ_t.
int short_lives_in_the_rest(const GaussianModel& model) {
  constexpr double kLife = 2.3548, kFrame = 1.0 / (kMoments - 1);
  int count = 0;
  const Slicer slicer(model);
  for (const MovingGaussian& g : slicer.moving()) {
    const double life = kLife / std::sqrt(double(g.spacetime.precision_time));
    const double at = g.spacetime.mean_time;
    count += life < kMoves && at > kMoves + kFrame && at < 1 - kMoves - kFrame;
  }
  return count;
}

/// Mean over pixels of the standard deviation over the moments of the rest, 8-bit steps.
double unrest(const std::vector<Picture>& pictures) {
  constexpr size_t kFirst = 7, kLast = 43;
  double total = 0;
  for (size_t i = 0; i < pictures[0].rgb.size(); ++i) {
    double sum = 0, squares = 0;
    for (size_t m = kFirst; m <= kLast; ++m) {
      const double value = 255 * std::clamp(double(pictures[m].rgb[i]), 0.0, 1.0);
      sum += value, squares += value * value;
    }
    const double count = kLast - kFirst + 1, mean = sum / count;
    total += std::sqrt(std::max(0.0, squares / count - mean * mean));
  }
  return total / double(pictures[0].rgb.size());
}

// Falls short of the row, which demands no variance in the rest: its mean deviation is 0.18 steps,
// and 12 at the worst value, because nothing that once moved becomes static.
// Bug put back: lives start at a hundredth of the clip; seen to fail by short lives in the rest.
TEST(LongRest, IsHeldByLongLives) {
  const Film film = resting_film();
  Scene scene = shoot(film);
  scene.points = surface_cloud(film, 200, 400);
  const GaussianModel model = trained(scene, short_training("balanced", 500));
  EXPECT_GT(model.dynamic_set.count(), 100);
  // none was seen; a hundredth is left to other rounding
  EXPECT_LE(short_lives_in_the_rest(model), model.dynamic_set.count() / 100);
  EXPECT_LT(unrest(middle_pictures(model, scene)), 0.5);
  EXPECT_GT(middle_psnr(model, scene), 28);
}

// Bug put back: the last eighth of the clip not looked at; seen to fail by 50 of 79 points.
TEST(LongRest, WhatLeavesAtTheEndIsNotStill) {
  Film film;
  film.moments = kMoments;
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
  const PointCloud cloud = dense_cloud(shoot(film), options);
  int ball = 0, still = 0;
  for (size_t i = 0; i < cloud.position.size(); ++i)
    if (cloud.position[i].z > 0) ++ball, still += cloud.still[i] == 1;
  EXPECT_GT(ball, 30);
  EXPECT_LT(still, ball / 10) << "where the ball looks alike";
}

}  // namespace
}  // namespace tessera::testing
