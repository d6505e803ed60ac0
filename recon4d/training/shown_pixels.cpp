// Counts of pixels that are used and not empty, and the limit that follows.
#include "recon4d/training/shown_pixels.h"

#include <algorithm>
#include <cmath>

#include "recon4d/options/presets.h"

namespace tessera {
namespace {

/// Pixels of a frame that its mask does not ignore, and of images with alpha those that differ from
/// the background; by every fourth row.
int64_t shown_pixels(const Scene& scene, const Frame& frame) {
  constexpr int kStep = 4;
  const int width = frame.image.width, height = frame.image.height;
  const std::vector<uint8_t>& mask = frame.mask.data();
  if (!scene.had_alpha && mask.empty()) return int64_t(width) * height;
  int64_t shown = 0, rows = 0;
  for (int y = 0; y < height; y += kStep, ++rows)
    for (size_t p = size_t(y) * size_t(width); p < size_t(y + 1) * size_t(width); ++p) {
      const bool empty =
          scene.had_alpha && std::equal(scene.background.begin(), scene.background.end(),
                                        frame.image.data.begin() + ptrdiff_t(3 * p));
      shown += !empty && (mask.empty() || mask[p] != 0);
    }
  return shown * height / std::max<int64_t>(1, rows);
}

}  // namespace

std::optional<double> limit_by_shown_pixels(const Scene& scene, TrainOptions& options) {
  if (options.gaussians_per_pixel == 0 || options.peak_gaussians == 0) return std::nullopt;
  int64_t frames = 0, shown = 0;
  for (const Frame& frame : scene.frames) {
    if (frame.split != Split::kTrain || frame.image.data.empty()) continue;
    ++frames;
    shown += shown_pixels(scene, frame);
  }
  if (frames == 0) return std::nullopt;
  const double pixels = double(shown) / double(frames);
  const int64_t before = options.peak_gaussians;
  lower_limit(options, std::llround(options.gaussians_per_pixel * pixels));
  return options.peak_gaussians < before ? std::optional(pixels) : std::nullopt;
}

}  // namespace tessera
