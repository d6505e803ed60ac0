// A wall without texture in all images, from initial Gaussians at any place and all dynamic.
// Source: failure mode C19.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/median.h"
#include "recon4d/reduction/contributions.h"
#include "tests/recon4d/modes/modes_film.h"

namespace tessera::testing {
namespace {

constexpr int kPoints = 300;

Film grey_film() {
  Film film;
  film.timesteps = 9;
  film.alpha = false;
  film.world = [](double) {
    synth::World world = even_world();
    synth::Texture grey;
    add_solid(world, synth::ShapeKind::kQuad, {4, 4, 0}, {0, 0, 0}, grey, false);
    return world;
  };
  return film;
}

/// Deviation of depths (y, across the wall) by light, world units.
double depth_deviation(const GaussianModel& model, const Scene& scene) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  const Contributions contributions =
      measure_contributions(*backend, model, sample_training_frames(scene));
  double light = 0, sum = 0, squares = 0;
  for (int k = 0; k < 2; ++k) {
    const GaussianSet& set = k == 0 ? model.static_set : model.dynamic_set;
    for (int64_t n = 0; n < set.count(); ++n) {
      const double w = contributions.sets[k].weight[size_t(n)], y = set.values().at(kMean, n)[1];
      light += w;
      sum += w * y;
      squares += w * y * y;
    }
  }
  return std::sqrt(squares / light - sum / light * sum / light);
}

// Nothing determines their depth: they stay where they were put, 2.6 units for 2.4. Medians of nine
// seeds, because single trainings differ by more than what is tested: the number of Gaussians is
// 160 to 360 (medians of five: 230 to 310), the PSNR 42 to 55 dB, and the worst flicker 0.1 to 2
// steps (medians: 0.6 by g++ 12, 1.0 by g++ 14; falls short of A14, which has 0.5). Bugs put back,
// each seen to fail: nothing is pruned and growth has no threshold (their number); means learn
// 3,000 times as fast (their depth).
TEST(Wall, WithoutTextureIsPruned) {
  const Scene scene = shoot(grey_film());
  TrainOptions options = short_training("balanced", 400);
  options.init_points = kPoints;
  std::vector<double> count, psnr, depth, flicker;
  for (options.seed = 1; options.seed <= 9; ++options.seed) {
    const GaussianModel first = first_state(scene, options).model.clone_values();
    const GaussianModel model = decided(scene, options);
    const std::vector<double> deviation = deviation_over_time(middle_images(model, scene));
    count.push_back(double(model.count()));
    psnr.push_back(middle_psnr(model, scene));
    depth.push_back(depth_deviation(model, scene) / depth_deviation(first, scene));
    flicker.push_back(*std::max_element(deviation.begin(), deviation.end()));
  }
  EXPECT_LE(median(count), kPoints);
  EXPECT_GT(median(psnr), 45);
  EXPECT_LT(median(depth), 1.25);
  EXPECT_LT(median(flicker), 2);
}

}  // namespace
}  // namespace tessera::testing
