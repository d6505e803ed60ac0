// Sums over the pixels of a drawn 8-bit image and its truth, in exact integers and with the moving
// pixels apart. The squared error and the colour fit of a camera (gain and offset of each channel
// by least squares) follow from them without the images.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

/// Of one channel, x: drawn, y: truth, both in 8-bit units.
struct ChannelSums {
  int64_t x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

struct PixelSums {
  int64_t pixels = 0;
  std::array<ChannelSums, 3> channels;

  /// Counts one pixel: its three drawn and three true values.
  void add(const uint8_t* drawn, const uint8_t* truth);
  PixelSums& operator+=(const PixelSums& other);
  /// Mean of (x − y)² over pixels and channels at range 1; there must be a pixel.
  double mean_squared_error() const;
};

/// Of one view, over the pixels that the mask of the frame uses.
struct ViewPixelSums {
  PixelSums moving, still;  // `still` has all pixels where moving ones are not known
  bool has_motion = false;

  PixelSums all() const { return PixelSums(moving) += still; }
};

/// `drawn`: RGB, of the size of the frame. `moves`: [height, width] 0 where nothing moves, as of
/// DynamicRegions; empty: not known.
ViewPixelSums view_sums(const Image8& drawn, const Frame& frame, const std::vector<uint8_t>& moves);

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
