// What: scenes for the terms in velocities and lives: some Gaussians out of sight, pairs of some.
// Not: how pairs are found (recon4d/training/rigidity.h).
#pragma once
#include "tests/support/render.h"

namespace tessera::testing {

/// Each Gaussian with the next and with the third after it.
inline TestPairs ring_of_pairs(int64_t count, Random& random) {
  std::vector<std::vector<std::pair<int32_t, double>>> ends(static_cast<size_t>(count));
  for (int64_t n = 0; n < count; ++n)
    for (const int64_t step : {1, 3}) {
      if (n + step >= count) continue;
      const double affinity = random.uniform(0.1, 1) / double(count);
      ends[size_t(n)].emplace_back(int32_t(n + step), affinity);
      ends[size_t(n + step)].emplace_back(int32_t(n), affinity);
    }
  TestPairs pairs;
  pairs.first.push_back(0);
  for (const auto& list : ends) {
    for (const auto& [other, affinity] : list)
      pairs.other.push_back(other), pairs.affinity.push_back(affinity);
    pairs.first.push_back(int64_t(pairs.other.size()));
  }
  return pairs;
}

/// A third of both sets is out of sight; one in five of the moving ones lives longer than the clip.
inline TestScene<double> motion_scene(Form form, int64_t fixed, int64_t moving, uint64_t seed) {
  TestScene<double> scene = random_scene(fixed, moving, 0.2, seed, form);
  Random random(seed + 1);
  scene.pairs = ring_of_pairs(moving, random);
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (int64_t n = 0; n < set->count; n += 3) set->at(kMean, n)[1] = 500;
  for (int64_t n = 1; n < moving; n += 5) *scene.moving.at(kLogScaleTime, n) = std::log(2.5);
  keep_truth_away(scene, seed + 2);
  return scene;
}

}  // namespace tessera::testing
