// An RGB image of uniform noise.
#pragma once
#include <cstdint>
#include <vector>

#include "ingest/scene.h"
#include "tests/support/random.h"

namespace tessera::testing {

inline Image8 random_image(int width, int height, uint64_t seed) {
  Random random(seed);
  Image8 image{width, height, 3, std::vector<uint8_t>(size_t(3 * width * height))};
  for (uint8_t& byte : image.data) byte = uint8_t(random.below(256));
  return image;
}

}  // namespace tessera::testing
