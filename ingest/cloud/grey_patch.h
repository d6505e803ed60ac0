// Grey images, and patches of them in whole numbers, a row as one vector register.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "ingest/scene.h"
#include "kernels/math/patch.h"

namespace tessera {

inline RgbView rgb_of(const Image8& image) {
  return {image.data.data(), image.width, image.height};
}

/// One byte a pixel, for searches over many depths.
struct GreyImage {
  int width = 0, height = 0;
  std::vector<uint8_t> level;
};

inline GreyImage grey_image(const Image8& image) {
  GreyImage grey{image.width, image.height, std::vector<uint8_t>(image.data.size() / 3)};
  for (size_t i = 0; i < grey.level.size(); ++i)
    grey.level[i] = grey_level(image.data.data() + 3 * i);
  return grey;
}

/// A row of a patch, and lanes behind it that are 0: one vector register.
using PatchRow = int16_t __attribute__((vector_size(16)));
inline constexpr PatchRow kInRow = {-1, -1, -1, -1, -1, 0, 0, 0};

inline int sum_of(const PatchRow& row) {
  return row[0] + row[1] + row[2] + row[3] + row[4];
}

/// As Patch, in whole numbers: levels less their mean, times kPixels.
struct GreyPatch {
  std::array<PatchRow, size_t(Patch::kSide)> level;
  int sum;  // of the levels
};

/// `image`: [height, width]. has_patch must hold: then each row and the lanes behind it lie in the
/// image's memory.
inline GreyPatch grey_patch_at(const uint8_t* image, int width, int x, int y) {
  const uint8_t* from = image + int64_t(y - Patch::kRadius) * width + int64_t(x - Patch::kRadius);
  GreyPatch patch;
  PatchRow columns{};
  for (PatchRow& row : patch.level) {
    uint8_t __attribute__((vector_size(8))) bytes;
    std::memcpy(&bytes, from, sizeof bytes);
    row = __builtin_convertvector(bytes, PatchRow) & kInRow;
    columns += row;
    from += width;
  }
  patch.sum = sum_of(columns);
  const PatchRow mean = (PatchRow{} + int16_t(patch.sum)) & kInRow;
  for (PatchRow& row : patch.level) row = int16_t(Patch::kPixels) * row - mean;
  return patch;
}

/// Mean absolute difference of the structure, levels.
inline float difference(const GreyPatch& a, const GreyPatch& b) {
  uint16_t __attribute__((vector_size(16))) columns{};  // at most 5 · 2 · 25 · 255 each
  for (size_t r = 0; r < a.level.size(); ++r) {
    const PatchRow d = a.level[r] - b.level[r];
    columns += decltype(columns)(d > -d ? d : -d);
  }
  const int sum = columns[0] + columns[1] + columns[2] + columns[3] + columns[4];
  return float(sum) / float(Patch::kPixels * Patch::kPixels);
}

}  // namespace tessera
