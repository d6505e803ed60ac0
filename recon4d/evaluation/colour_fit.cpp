// The normal equations of a line in closed form, channel by channel.
#include "recon4d/evaluation/colour_fit.h"

#include <algorithm>

#include "kernels/base/errors.h"

namespace tessera {

double ColourFit::mean_squared_error(const PixelSums& sums) const {
  check(sums.pixels > 0, "colour fit: at least one pixel");
  double error = 0;
  for (size_t c = 0; c < 3; ++c) {
    const ChannelSums& s = sums.channels[c];
    const double g = gain[c], o = 255 * offset[c], n = double(sums.pixels);
    const double channel = g * g * double(s.xx) + n * o * o + double(s.yy) +
                           2 * (g * o * double(s.x) - g * double(s.xy) - o * double(s.y));
    error += std::max(0.0, channel);  // rounding makes an error of 0 negative
  }
  return error / (255.0 * 255.0 * 3.0 * double(sums.pixels));
}

ColourFit fit_colour(const PixelSums& sums) {
  check(sums.pixels > 0, "colour fit: at least one pixel");
  ColourFit fit;
  const double n = double(sums.pixels);
  for (size_t c = 0; c < 3; ++c) {
    const ChannelSums& s = sums.channels[c];
    const double mean_x = double(s.x) / n, mean_y = double(s.y) / n;
    const double variance = double(s.xx) / n - mean_x * mean_x;
    constexpr double kLeastVariance = 1e-6;  // 8-bit units; of one value, rounding leaves less
    if (variance > kLeastVariance) fit.gain[c] = (double(s.xy) / n - mean_x * mean_y) / variance;
    fit.offset[c] = (mean_y - fit.gain[c] * mean_x) / 255.0;
  }
  return fit;
}

}  // namespace tessera
