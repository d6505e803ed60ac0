// The share of dynamic Gaussians in each pixel, from an image of the model with a white dynamic set
// and a black rest, and the part of this share inside masks of what moves. Source: Σ_n w_n over the
// dynamic set, w_n = α_n ∏_{m<n} (1 − α_m)  [3DGS, Eq. 3].
#pragma once
#include <optional>
#include <vector>

#include "recon4d/evaluation/render.h"

namespace tessera {

/// The model with its dynamic Gaussians white and all else black: static ones, background, no
/// environment, no levels of time. Each channel of its images is the dynamic share, 0 … 1.
GaussianModel dynamic_set_white(const GaussianModel& model);

/// Σ w over the dynamic set: one image per view, [height, width].
std::vector<std::vector<float>> dynamic_share(Backend& backend, const GaussianModel& model,
                                              const std::vector<View>& views);

/// The dynamic share against masks of what moves, over any number of images.
struct MovingRegionScore {
  double weight = 0, weight_inside = 0;  // Σ w over pixels: all, of the region
  int64_t moving_pixels = 0,
          covered_pixels = 0;  // that move now; of these, covered by the dynamic set

  /// A pixel is of the region where its mask has at least kRegion: something moves there at some
  /// timestep, be it over a part of the pixel; nothing is dilated. It moves now where the mask has
  /// at least kMovingNow: over half of the pixel or more. It is covered where the dynamic share is
  /// at least kCovered.
  static constexpr uint8_t kRegion = 128, kMovingNow = 192;
  static constexpr float kCovered = 0.5f;

  /// share, mask: [height, width]; `used`: the same or empty, pixels of 0 do not count.
  void add(const std::vector<float>& share, const std::vector<uint8_t>& mask,
           const std::vector<uint8_t>& used = {});
  /// Share of the dynamic weight that lies in the region; nothing where there is no weight.
  std::optional<double> dynamic_weight_inside() const;
  /// Share of the pixels that move now that are covered; nothing where none moves.
  std::optional<double> moving_pixels_covered() const;
};

}  // namespace tessera
