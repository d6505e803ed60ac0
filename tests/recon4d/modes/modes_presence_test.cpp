// An object that is visible for a fifth of the clip, and one that is hidden for a while. Source:
// failure modes A7, A8.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/base/median.h"
#include "recon4d/evaluation/metrics.h"
#include "tests/recon4d/modes/modes_film.h"

namespace tessera::testing {
namespace {

constexpr int kFirst = 8, kLast = 12;  // timesteps of 21 at which the cube is there

/// A ball stands on the left; on the right a cube is there for t in [0.4, 0.6].
Film cube_film() {
  Film film;
  film.timesteps = 21;
  film.world = [last = film.timesteps - 1](double) {
    synth::World world = even_world();
    add_solid(world, synth::ShapeKind::kSphere, glm::dvec3(0.35), {-0.6, 0, 0}, warm(0.12), false);
    synth::Solid& cube =
        add_solid(world, synth::ShapeKind::kBox, glm::dvec3(0.25), {0.5, 0, 0}, cold(0.15));
    cube.lifetime = {(kFirst - 0.5) / last, (kLast + 0.5) / last};
    return world;
  };
  return film;
}

std::vector<double> psnr_by_timestep(const std::vector<RenderedImage>& images, const Scene& scene) {
  const std::vector<const Frame*> frames = held_out(scene);
  std::vector<double> values;
  for (size_t i = 0; i < images.size(); ++i)
    values.push_back(psnr_float(images[i].planar(), frames[i]->image));
  return values;
}

double mean(const std::vector<double>& values, int first, int last) {
  double sum = 0;
  for (int i = first; i <= last; ++i) sum += values[size_t(i)];
  return sum / (last - first + 1);
}

// Falls short of the row in the frame right before and the one right after the cube, which show 36
// and 11 steps of it (11 and 26 after 4,000 steps): all others are the same to 2 steps.
// Bug put back: temporal extents are not trained; seen to fail, the cube is never drawn.
TEST(Presence, WhatAppearsIsGoneBeforeAndAfter) {
  Scene scene = shoot(cube_film());
  scene.points = surface_cloud(cube_film(), 200, 200);
  TrainOptions options = short_training("balanced", 500);
  options.lr_scale_time = 0.02;  // extents change as much as in the preset's steps
  const GaussianModel model = trained(scene, options);
  const std::vector<RenderedImage> images = middle_images(model, scene);
  EXPECT_GT(mean(psnr_by_timestep(images, scene), kFirst, kLast), 30);
  for (int m = 0; m < int(images.size()); ++m) {
    if (m >= kFirst - 1 && m <= kLast + 1) continue;
    EXPECT_LT(largest_difference(images[size_t(m)], images[0]), 2) << m;
  }
}

/// A ball passes behind a wall and comes back the way it went.
Film wall_film() {
  Film film;
  film.timesteps = 25;
  film.arc = 0.8;
  film.world = [](double time) {
    synth::World world = even_world();
    const double x = -0.7 + 0.95 * (1 - std::abs(2 * time - 1));
    add_solid(world, synth::ShapeKind::kSphere, glm::dvec3(0.2), {x, 0.5, 0}, warm(0.12));
    add_solid(world, synth::ShapeKind::kBox, {0.5, 0.05, 0.5}, {0.3, 0, 0}, cold(0.15), false);
    return world;
  };
  return film;
}

// Medians of three seeds. Bug put back: all start at the first timestep; seen to fail by 8 dB.
TEST(Presence, WhatComesBackIsAsItWas) {
  Scene scene = shoot(wall_film());
  scene.points = surface_cloud(wall_film(), 200, 400);
  TrainOptions options = short_training("balanced", 500);
  options.max_gaussians = 2000;
  std::vector<double> before, gain;
  for (options.seed = 1; options.seed <= 3; ++options.seed) {
    const GaussianModel model = trained(scene, options);
    const std::vector<double> psnr = psnr_by_timestep(middle_images(model, scene), scene);
    const int last = int(psnr.size()) - 1;
    before.push_back(mean(psnr, 0, 6));
    gain.push_back(mean(psnr, last - 6, last) - before.back());
  }
  EXPECT_GT(median(before), 30);
  EXPECT_GT(median(gain), -0.5);
}

}  // namespace
}  // namespace tessera::testing
