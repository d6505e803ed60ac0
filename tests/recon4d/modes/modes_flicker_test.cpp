// A background that never changes behind a moving object. Source: failure mode A14.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/median.h"
#include "tests/recon4d/modes/modes_film.h"

namespace tessera::testing {
namespace {

/// A ball moves up and down in front of the left half of a wall.
Film wall_film() {
  Film film;
  film.timesteps = 21;
  film.world = [](double time) {
    synth::World world = even_world();
    add_solid(world, synth::ShapeKind::kSphere, glm::dvec3(0.22),
              {-0.55, -0.4, 0.5 * std::sin(6.283185307 * time)}, warm(0.12));
    add_solid(world, synth::ShapeKind::kQuad, {2, 2, 0}, {0, 0.3, 0}, cold(0.2), false);
    return world;
  };
  return film;
}

/// [height, width] 1 where the frames differ within `margin` pixels, both ways.
std::vector<uint8_t> changing(const std::vector<const Frame*>& frames, int margin) {
  const Image8& first = frames[0]->image;
  std::vector<uint8_t> changes(first.data.size() / 3);
  for (const Frame* frame : frames)
    for (size_t i = 0; i < first.data.size(); ++i)
      if (frame->image.data[i] != first.data[i]) {
        const int x = int(i / 3) % first.width, y = int(i / 3) / first.width;
        for (int v = std::max(0, y - margin); v <= std::min(first.height - 1, y + margin); ++v)
          for (int u = std::max(0, x - margin); u <= std::min(first.width - 1, x + margin); ++u)
            changes[size_t(v * first.width + u)] = 1;
      }
  return changes;
}

// All Gaussians start dynamic. Falls short of the row, which has 0.5 steps for every pixel. Of
// those pixels that are two or more from where anything ever moves, 98 of 100 are below 0.3 to 0.7
// steps, by seed and compiler (medians of three seeds: 0.39 by g++ 12, 0.71 by g++ 14); the worst
// of all is 2 to 5. The bounds lie between these and the bug put back, nothing becomes static,
// which was seen to fail by 9.6 and 28.
TEST(Flicker, ABackgroundThatNeverChangesStays) {
  const Film film = wall_film();
  Scene scene = shoot(film);
  scene.points = surface_cloud(film, 600, 200);
  TrainOptions options = short_training("balanced", 500);
  options.split_by_motion = false;
  options.static_fraction = 0;
  const std::vector<uint8_t> changes = changing(held_out(scene), 2);
  std::vector<double> most, worst;
  for (options.seed = 1; options.seed <= 3; ++options.seed) {
    const GaussianModel model = decided(scene, options);
    EXPECT_GT(model.dynamic_set.count(), 20);
    const std::vector<double> all = deviation_over_time(middle_images(model, scene));
    std::vector<double> unchanged;
    for (size_t i = 0; i < all.size(); ++i)
      if (!changes[i % changes.size()]) unchanged.push_back(all[i]);
    ASSERT_GT(unchanged.size(), all.size() / 2);
    std::sort(unchanged.begin(), unchanged.end());
    most.push_back(unchanged[unchanged.size() * 98 / 100]);
    worst.push_back(unchanged.back());
  }
  EXPECT_LT(median(most), 1);
  EXPECT_LT(median(worst), 5);
}

}  // namespace
}  // namespace tessera::testing
