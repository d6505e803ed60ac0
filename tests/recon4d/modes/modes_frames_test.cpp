// The same motion filmed with fewer frames and with ten times as many. Source: failure modes A15,
// A16.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/recon4d/modes/modes_film.h"
#include "tests/support/separate_backend.h"

namespace tessera::testing {
namespace {

/// A ball on a curve above a shelf.
Film curve_film(int timesteps, double cycles) {
  Film film;
  film.timesteps = timesteps;
  film.world = [cycles](double time) {
    const double turn = 2 * std::numbers::pi * cycles * time;
    synth::World world = even_world();
    add_solid(world, synth::ShapeKind::kSphere, glm::dvec3(0.3),
              {0.5 * std::sin(turn), 0, 0.1 + 0.15 * std::cos(2 * turn)}, warm(0.12));
    add_solid(world, synth::ShapeKind::kBox, {1, 0.3, 0.15}, {0, 0, -0.6}, cold(0.15), false);
    return world;
  };
  return film;
}

// Of all frames of the held-out camera, whether their timestep was trained on or not; the same
// steps. Bug put back: only the first 54 frames are ever drawn; seen to fail.
TEST(FrameRate, FewerFramesAreNeverBetter) {
  constexpr int kMoments = 33;
  constexpr double kBand = 0.5;  // dB between two seeds
  const Scene all = shoot(curve_film(kMoments, 1));
  double before = 100;
  for (const int skip : {1, 2, 4}) {
    Scene scene = all;
    for (Frame& frame : scene.frames)
      if (frame.frame_number % skip != 0) frame.split = Split::kTest;
    scene.points = surface_cloud(curve_film((kMoments - 1) / skip + 1, 1), 200, 400);
    const double psnr = middle_psnr(trained(scene, short_training("balanced", 500)), all);
    EXPECT_LT(psnr, before + kBand) << "every frame number " << skip;
    EXPECT_GT(psnr, 22);
    before = psnr;
  }
}

// The same motion in ten times the frames, trained for the same steps, scored at the timesteps that
// both were trained on. The row's 0.3 dB hold in the mean of three seeds, which gained −0.46, −0.35
// and 0.38 dB; that spread is allowed here.
// Bug put back: only the first 54 frames are ever drawn; seen to fail by 7 dB.
TEST(LongClip, TenTimesTheFramesAreAsGood) {
  constexpr double kCycles = 0.25, kAllowed = 0.3, kSpread = 0.5;  // dB
  const Scene few = shoot(curve_film(9, kCycles));
  double psnr[2];
  for (const int timesteps : {9, 81}) {
    const Film film = curve_film(timesteps, kCycles);
    Scene scene = timesteps == 9 ? few : shoot(film);
    scene.points = surface_cloud(film, 200, 400);
    psnr[timesteps > 9] = middle_psnr(trained(scene, short_training("balanced", 500)), few);
  }
  EXPECT_GT(psnr[1], psnr[0] - kAllowed - kSpread);
}

/// Bytes of a device that a training of some steps holds at most, frames brought over by a ring.
int64_t peak_of_training(const Scene& scene, int64_t feed_bytes) {
  TrainOptions options = short_training("balanced", 6);
  options.densify_from = options.iterations;
  options.feed_bytes = feed_bytes;
  SeparateBackend backend;
  Training training(scene, options, first_state(scene, options), backend);
  training.run();
  return backend.separate_memory.peak_bytes();
}

// Bug put back: the budget not read, all frames brought over; seen to fail.
TEST(LongClip, TenTimesTheFramesTakeNoMoreOfADevice) {
  int64_t peak[2], whole = 0;
  for (const int timesteps : {9, 81}) {
    Scene scene = shoot(curve_film(timesteps, 0.5));
    scene.points = surface_cloud(curve_film(9, 0.5), 200, 400);
    peak[timesteps > 9] = peak_of_training(scene, 1);
    if (timesteps > 9) whole = peak_of_training(scene, 0);
  }
  EXPECT_LT(double(peak[1]), 1.2 * double(peak[0]));
  EXPECT_GT(double(whole), 1.2 * double(peak[0])) << "frames do count";
}

}  // namespace
}  // namespace tessera::testing
