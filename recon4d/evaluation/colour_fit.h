// The gain and offset of each camera and channel that bring drawn images nearest to the truth, by
// least squares, and the squared error that they leave. What a score gains by them is what the
// colours of cameras alone cost. The offset makes it more than a fit of exposure.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "recon4d/evaluation/pixel_sums.h"

namespace tessera {

/// truth ≈ gain · drawn + offset, values in [0, 1]. What it makes is neither rounded nor clamped.
struct ColourFit {
  std::array<double, 3> gain{1, 1, 1}, offset{0, 0, 0};

  /// Mean of (gain · x + offset − y)² over pixels and channels; there must be a pixel.
  double mean_squared_error(const PixelSums& sums) const;
};

struct CameraColourFit {
  std::string camera;
  ColourFit fit;
};

/// The fit of least squared error over all pixels of `sums`, in closed form. Where a channel is
/// drawn in one value, gains are not determined: the gain is 1 and the offset the mean difference.
ColourFit fit_colour(const PixelSums& sums);

}  // namespace tessera
