// SSIM of 8-bit images under the name of each protocol, and multi-scale SSIM. The window and its
// convolution are in kernels/stages/ssim_window.h. Source: [Wang04], [Wang03]; method A.15; failure
// modes D1, B20.
#pragma once
#include <optional>

#include "recon4d/evaluation/metrics.h"

namespace tessera {

enum class SsimPadding { kReflect, kZero };
/// Mean over the full map and channels, 11 taps, σ 1.5, range 1. Nothing where the window does not
/// fit: reflection needs more than 5 pixels each way. In the windows of used pixels b is a where
/// the mask ignores, so that nothing is compared there.
std::optional<double> ssim(const Image8& a, const Image8& b, SsimPadding padding,
                           Span<const uint8_t> mask = {});

/// All means over channels, nothing where undefined. Masks as for `ssim`.
struct StructureScores {
  std::optional<double> reflect, zero;  // `ssim` of that padding
  /// Windows that lie inside the image alone, from 11 pixels each way: scikit-image's mean with
  /// Gaussian weights. Of values in [0, 1], at range 1 and, as some papers print it, at range 2.
  std::optional<double> inside, inside_range2;
  /// Five scales of [Wang03], weights .0448 .2856 .3001 .2363 .1333, reflected; 2 × 2 means between
  /// them, an odd last row or column dropped; negative factors are 0. Nothing for sides below 161
  /// pixels or with a mask.
  std::optional<double> multi_scale;
};
inline constexpr int kMultiScaleSide = 161;  // pixels: the window fits at the fifth scale

StructureScores structure_scores(const Image8& a, const Image8& b, Span<const uint8_t> mask = {});

}  // namespace tessera
