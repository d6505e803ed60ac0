// A scene whose static set is carried by motion nodes, beside dynamic Gaussians.
#pragma once
#include "tests/support/test_scene.h"

namespace tessera::testing {

/// Every fifth Gaussian is bound to no node, others to 1 … 8.
inline TestScene<double> carried_scene(uint64_t seed, int64_t count = 8, int64_t nodes = 9,
                                       double size = 0.25, int64_t moving = 3) {
  TestScene<double> scene = random_scene(count, moving, size, seed);
  Random random(seed + 1);
  scene.nodes = random_nodes(nodes, 6, random);
  scene.fixed = canonical(scene.fixed, scene.nodes, random,
                          [](int64_t n) { return n % 5 == 4 ? 0 : 1 + n % 8; });
  return scene;
}

}  // namespace tessera::testing
