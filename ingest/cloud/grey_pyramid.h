// A grey image at several sizes, and square windows of it at sub-pixel positions.
#pragma once
#include <array>
#include <vector>

#include "ingest/cloud/grey_patch.h"

namespace tessera {

/// Level l has sides of 2^−l of the image's: a position (u, v), pixels, centres at +0.5, is
/// (u, v) / 2^l there.
using GreyPyramid = std::vector<GreyImage>;
inline constexpr int kPyramidLevels = 4;

/// Each level is the mean over 2 × 2 pixels of the one before; fewer levels of tiny images.
GreyPyramid grey_pyramid(const Image8& image);

/// A square of levels less their mean, around a position.
struct GreyWindow {
  static constexpr int kRadius = 3, kSide = 2 * kRadius + 1, kPixels = kSide * kSide;
  std::array<float, size_t(kPixels)> level;
};

/// Its derivatives along u and v, levels a pixel, less their means.
struct WindowGradient {
  std::array<float, size_t(GreyWindow::kPixels)> along_u, along_v;
};

/// Whether the window around (u, v) and two pixels more lie in the image; false for NaN.
bool has_window(const GreyImage& image, double u, double v);
/// Bilinear. has_window must hold.
GreyWindow window_at(const GreyImage& image, double u, double v);
/// Central differences. has_window must hold.
WindowGradient gradient_at(const GreyImage& image, double u, double v);

/// Mean absolute difference, levels.
float difference(const GreyWindow& a, const GreyWindow& b);

}  // namespace tessera
