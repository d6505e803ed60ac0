// Affine colour maps for tests, and access to their numbers one by one.
#pragma once
#include <array>

#include "kernels/math/colour_map.h"
#include "tests/support/random.h"

namespace tessera::testing {

/// Near the identity; colours of [0, 1] stay near it.
inline ColourMap<double> random_colour_map(Random& random) {
  ColourMap<double> map;
  for (int i = 0; i < 9; ++i) map.matrix[i / 3][i % 3] += random.uniform(-0.2, 0.2);
  for (int c = 0; c < 3; ++c) map.offset[c] = random.uniform(-0.1, 0.1);
  return map;
}

/// The twelve numbers of a map: its matrix column by column, then its offset.
inline std::array<double*, 12> numbers_of(ColourMap<double>& map) {
  std::array<double*, 12> numbers;
  for (int i = 0; i < 9; ++i) numbers[size_t(i)] = &map.matrix[i / 3][i % 3];
  for (int c = 0; c < 3; ++c) numbers[size_t(9 + c)] = &map.offset[c];
  return numbers;
}
inline std::array<double, 12> numbers_of(const ColourMap<double>& map) {
  ColourMap<double> copy = map;
  std::array<double, 12> numbers;
  for (size_t i = 0; i < 12; ++i) numbers[i] = *numbers_of(copy)[i];
  return numbers;
}

}  // namespace tessera::testing
