// Small square patches of RGB images, and their difference up to brightness: the sum of absolute
// differences of levels minus their mean, for each channel. On host and device alike.
#pragma once
#include <cmath>
#include <cstdint>

#include "kernels/base/host_device.h"

namespace tessera {

/// The pixels of an RGB image, [height, width, 3], row-major, top row first.
struct RgbView {
  const uint8_t* data = nullptr;
  int width = 0, height = 0;

  TESSERA_HD const uint8_t* at(int x, int y) const {
    return data + 3 * (int64_t(y) * width + int64_t(x));
  }
};

struct Patch {
  static constexpr int kRadius = 2, kSide = 2 * kRadius + 1, kPixels = kSide * kSide;
  static constexpr int kBorder = kRadius + 1;  // of an image, around which there is none
  static constexpr int kLevels = 3 * kPixels;
  float level[kLevels];  // interleaved, less the channel's mean
  float mean[3];
};

/// Whether the patch around pixel (x, y) and a pixel more lie in the image.
TESSERA_HD inline bool has_patch(const RgbView& image, int x, int y) {
  constexpr int kBorder = Patch::kBorder;
  return x >= kBorder && y >= kBorder && x < image.width - kBorder && y < image.height - kBorder;
}

/// Takes the means out of `level`.
TESSERA_HD inline void centre(Patch& patch) {
  for (float& mean : patch.mean) mean = 0;
  for (int i = 0; i < Patch::kLevels; i += 3)
    for (int c = 0; c < 3; ++c) patch.mean[c] += patch.level[i + c];
  for (float& mean : patch.mean) mean /= float(Patch::kPixels);
  for (int i = 0; i < Patch::kLevels; i += 3)
    for (int c = 0; c < 3; ++c) patch.level[i + c] -= patch.mean[c];
}

/// Around pixel (x, y). has_patch must hold.
TESSERA_HD inline Patch patch_at(const RgbView& image, int x, int y) {
  Patch patch;
  int i = 0;
  for (int dy = -Patch::kRadius; dy <= Patch::kRadius; ++dy) {
    const uint8_t* row = image.at(x - Patch::kRadius, y + dy);
    for (int k = 0; k < 3 * Patch::kSide; ++k) patch.level[i++] = float(row[k]);
  }
  centre(patch);
  return patch;
}

/// Around the position (u, v), pixels, centres at +0.5; bilinear. has_patch must hold for the
/// pixel that (u, v) lies in.
TESSERA_HD inline Patch patch_between(const RgbView& image, double u, double v) {
  const double left = std::floor(u - 0.5), top = std::floor(v - 0.5);
  const float a = float(u - 0.5 - left), b = float(v - 0.5 - top);
  const int64_t line = 3 * int64_t(image.width);
  Patch patch;
  int i = 0;
  for (int dy = -Patch::kRadius; dy <= Patch::kRadius; ++dy) {
    const uint8_t* row = image.at(int(left) - Patch::kRadius, int(top) + dy);
    for (int k = 0; k < 3 * Patch::kSide; ++k, ++row)
      patch.level[i++] = (1 - b) * ((1 - a) * float(row[0]) + a * float(row[3])) +
                         b * ((1 - a) * float(row[line]) + a * float(row[line + 3]));
  }
  centre(patch);
  return patch;
}

/// Mean absolute difference of the structure, levels: a gain of the whole patch is left out.
TESSERA_HD inline float difference(const Patch& a, const Patch& b) {
  float sum = 0;
  for (int i = 0; i < Patch::kLevels; ++i) sum += std::abs(a.level[i] - b.level[i]);
  return sum / float(Patch::kLevels);
}

/// Mean absolute difference of the channels' means, levels.
TESSERA_HD inline float brightness_difference(const Patch& a, const Patch& b) {
  float sum = 0;
  for (int c = 0; c < 3; ++c) sum += std::abs(a.mean[c] - b.mean[c]);
  return sum / 3;
}

/// Mean absolute deviation, levels: what `difference` would be from an even patch.
TESSERA_HD inline float texture(const Patch& patch) {
  float sum = 0;
  for (const float level : patch.level) sum += std::abs(level);
  return sum / float(Patch::kLevels);
}

/// One byte of a pixel, for searches over many depths.
TESSERA_HD inline uint8_t grey_level(const uint8_t* rgb) {
  return uint8_t((rgb[0] + 2 * rgb[1] + rgb[2]) / 4);
}

inline constexpr int kMostStillSights = 8;  // of a camera, at other times

/// An image of the same camera at another time.
struct StillSight {
  RgbView image;
  float light[3] = {1, 1, 1};  // brightness of the image that is compared by that of this one
  bool same_pose = true;       // of the camera
};

/// Whether the patch around pixel (x, y) is the same, after its light, at these times, the first
/// and the last among them, but for a quarter of them in between, in which it is quite another: a
/// moving object may occlude the static surface. True where the camera moves: then the comparison
/// is meaningless. has_patch must hold.
TESSERA_HD inline bool is_still(const RgbView& image, int x, int y, const StillSight* sights,
                                int count) {
  constexpr float kStill = 4;     // change over time of a still pixel, levels
  constexpr float kPassing = 12;  // likewise, of one before which something passes
  constexpr int kOfSights = 4;    // one of so many may show something that passes
  if (count == 0) return true;
  const Patch patch = patch_at(image, x, y);
  int passing = 0;
  for (int k = 0; k < count; ++k) {
    const StillSight& sight = sights[k];
    if (!sight.same_pose) return true;
    Patch then = patch_at(sight.image, x, y);
    for (int i = 0; i < Patch::kLevels; ++i) then.level[i] *= sight.light[i % 3];
    for (int c = 0; c < 3; ++c) then.mean[c] *= sight.light[c];
    const float structure = difference(patch, then), level = brightness_difference(patch, then);
    const float change = structure > level ? structure : level;
    if (change <= kStill) continue;
    // what passes has come and has gone
    const bool between = k > 0 && k < count - 1;
    if (change <= kPassing || !between) return false;
    ++passing;
    if (passing > count / kOfSights) return false;
  }
  return true;
}

}  // namespace tessera
