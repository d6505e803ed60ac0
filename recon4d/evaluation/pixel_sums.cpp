// The loop over the pixels of a view, the squared error from its sums, and the normal equations of
// the colour fit in closed form.
#include "recon4d/evaluation/pixel_sums.h"

#include <algorithm>

#include "kernels/base/errors.h"
#include "recon4d/evaluation/metrics.h"

namespace tessera {

void PixelSums::add(const uint8_t* drawn, const uint8_t* truth) {
  ++pixels;
  for (size_t c = 0; c < 3; ++c) {
    const int64_t x = drawn[c], y = truth[c];
    ChannelSums& sums = channels[c];
    sums.x += x;
    sums.y += y;
    sums.xx += x * x;
    sums.xy += x * y;
    sums.yy += y * y;
  }
}

PixelSums& PixelSums::operator+=(const PixelSums& other) {
  pixels += other.pixels;
  for (size_t c = 0; c < 3; ++c) {
    ChannelSums& sums = channels[c];
    const ChannelSums& more = other.channels[c];
    sums.x += more.x;
    sums.y += more.y;
    sums.xx += more.xx;
    sums.xy += more.xy;
    sums.yy += more.yy;
  }
  return *this;
}

double PixelSums::mean_squared_error() const {
  check(pixels > 0, "pixel sums: at least one pixel");
  int64_t sum = 0;
  for (const ChannelSums& c : channels) sum += c.xx - 2 * c.xy + c.yy;
  return double(sum) / (255.0 * 255.0 * double(3 * pixels));
}

ViewPixelSums view_sums(const Image8& drawn, const Frame& frame,
                        const std::vector<uint8_t>& moves) {
  check_pair(drawn, frame.image);
  const size_t pixels = drawn.data.size() / 3;
  check(moves.empty() || moves.size() == pixels, "pixel sums: moving pixels of the image's size");
  ViewPixelSums sums;
  sums.has_motion = !moves.empty();
  const Span<const uint8_t> mask = used_mask(frame);
  for (size_t p = 0; p < pixels; ++p) {
    if (!is_used(mask, p)) continue;
    PixelSums& region = !moves.empty() && moves[p] != 0 ? sums.moving : sums.still;
    region.add(&drawn.data[3 * p], &frame.image.data[3 * p]);
  }
  return sums;
}

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
