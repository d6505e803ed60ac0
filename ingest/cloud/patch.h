// Small square patches of images, and their difference up to brightness: the sum of absolute
// differences of levels minus their mean, for each channel.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

struct Patch {
  static constexpr int kRadius = 2, kSide = 2 * kRadius + 1, kPixels = kSide * kSide;
  static constexpr int kBorder = kRadius + 1;    // of an image, around which there is none
  std::array<float, size_t(3 * kPixels)> level;  // interleaved, less the channel's mean
  std::array<float, 3> mean;
};

/// Whether the patch around pixel (x, y) and a pixel more lie in the image.
inline bool has_patch(const Image8& image, int x, int y) {
  constexpr int kBorder = Patch::kBorder;
  return x >= kBorder && y >= kBorder && x < image.width - kBorder && y < image.height - kBorder;
}

/// Takes the means out of `level`.
inline void centre(Patch& patch) {
  patch.mean = {0, 0, 0};
  for (size_t i = 0; i < patch.level.size(); i += 3)
    for (size_t c = 0; c < 3; ++c) patch.mean[c] += patch.level[i + c];
  for (float& mean : patch.mean) mean /= float(Patch::kPixels);
  for (size_t i = 0; i < patch.level.size(); i += 3)
    for (size_t c = 0; c < 3; ++c) patch.level[i + c] -= patch.mean[c];
}

/// Around pixel (x, y) of an RGB image. has_patch must hold.
inline Patch patch_at(const Image8& image, int x, int y) {
  Patch patch;
  size_t i = 0;
  for (int dy = -Patch::kRadius; dy <= Patch::kRadius; ++dy) {
    const uint8_t* row =
        image.data.data() + 3 * (size_t(y + dy) * size_t(image.width) + size_t(x - Patch::kRadius));
    for (int k = 0; k < 3 * Patch::kSide; ++k) patch.level[i++] = float(row[k]);
  }
  centre(patch);
  return patch;
}

/// Begins to bring the same pixels to the cache.
inline void fetch_patch(const Image8& image, int x, int y) {
  for (int dy = -Patch::kRadius; dy <= Patch::kRadius; ++dy)
    __builtin_prefetch(image.data.data() +
                       3 * (size_t(y + dy) * size_t(image.width) + size_t(x - Patch::kRadius)));
}

/// Around the position (u, v), pixels, centres at +0.5; bilinear. has_patch must hold for the
/// pixel that (u, v) lies in.
inline Patch patch_between(const Image8& image, double u, double v) {
  const double left = std::floor(u - 0.5), top = std::floor(v - 0.5);
  const float a = float(u - 0.5 - left), b = float(v - 0.5 - top);
  const size_t line = 3 * size_t(image.width);
  Patch patch;
  size_t i = 0;
  for (int dy = -Patch::kRadius; dy <= Patch::kRadius; ++dy) {
    const uint8_t* row =
        image.data.data() + size_t(int(top) + dy) * line + 3 * size_t(int(left) - Patch::kRadius);
    for (int k = 0; k < 3 * Patch::kSide; ++k, ++row)
      patch.level[i++] = (1 - b) * ((1 - a) * float(row[0]) + a * float(row[3])) +
                         b * ((1 - a) * float(row[line]) + a * float(row[line + 3]));
  }
  centre(patch);
  return patch;
}

/// Mean absolute difference of the structure, levels: a gain of the whole patch is left out.
inline float difference(const Patch& a, const Patch& b) {
  float sum = 0;
  for (size_t i = 0; i < a.level.size(); ++i) sum += std::abs(a.level[i] - b.level[i]);
  return sum / float(a.level.size());
}

/// Mean absolute difference of the channels' means, levels.
inline float brightness_difference(const Patch& a, const Patch& b) {
  float sum = 0;
  for (size_t c = 0; c < 3; ++c) sum += std::abs(a.mean[c] - b.mean[c]);
  return sum / 3;
}

/// Mean absolute deviation, levels: what `difference` would be from an even patch.
inline float texture(const Patch& patch) {
  float sum = 0;
  for (float level : patch.level) sum += std::abs(level);
  return sum / float(patch.level.size());
}

/// One byte a pixel, for searches over many depths.
struct GreyImage {
  int width = 0, height = 0;
  std::vector<uint8_t> level;
};

inline GreyImage grey_image(const Image8& image) {
  GreyImage grey{image.width, image.height, std::vector<uint8_t>(image.data.size() / 3)};
  for (size_t i = 0; i < grey.level.size(); ++i)
    grey.level[i] =
        uint8_t((image.data[3 * i] + 2 * image.data[3 * i + 1] + image.data[3 * i + 2]) / 4);
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

/// has_patch must hold: then each row and the lanes behind it lie in the image's memory.
inline GreyPatch grey_patch_at(const GreyImage& image, int x, int y) {
  const uint8_t* from = image.level.data() + size_t(y - Patch::kRadius) * size_t(image.width) +
                        size_t(x - Patch::kRadius);
  GreyPatch patch;
  PatchRow columns{};
  for (PatchRow& row : patch.level) {
    uint8_t __attribute__((vector_size(8))) bytes;
    std::memcpy(&bytes, from, sizeof bytes);
    row = __builtin_convertvector(bytes, PatchRow) & kInRow;
    columns += row;
    from += image.width;
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
