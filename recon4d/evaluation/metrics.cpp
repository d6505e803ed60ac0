// Quantised images and sums over pixels, in double or in exact integers.
#include "recon4d/evaluation/metrics.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr double kPsnrCap = 100;  // dB, for images that are equal

/// NaN becomes 0.
float clamped(float value) {
  return value > 0.0f ? std::min(value, 1.0f) : 0.0f;
}

}  // namespace

void check_pair(const Image8& a, const Image8& b) {
  check(a.channels == 3 && b.channels == 3 && a.width == b.width && a.height == b.height &&
            a.width > 0 && a.height > 0,
        "metrics: two RGB images of one size");
}

size_t used_pixels(Span<const uint8_t> mask, size_t pixels) {
  check(mask.empty() || mask.size == int64_t(pixels), "metrics: a mask of the image's size");
  const size_t count =
      mask.empty() ? pixels : pixels - size_t(std::count(mask.begin(), mask.end(), uint8_t{0}));
  check(count > 0, "metrics: at least one pixel that is used");
  return count;
}

Image8 quantise(Span<const float> planar_rgb, int width, int height) {
  const size_t pixels = size_t(width) * size_t(height);
  check(planar_rgb.size == int64_t(3 * pixels), "quantise: [3, height, width] floats");
  Image8 image{width, height, 3, std::vector<uint8_t>(3 * pixels)};
  for (size_t p = 0; p < pixels; ++p)
    for (size_t c = 0; c < 3; ++c)
      image.data[3 * p + c] =
          uint8_t(std::floor(255.0f * clamped(planar_rgb.data[c * pixels + p]) + 0.5f));
  return image;
}

double mean_squared_error(const Image8& a, const Image8& b, Span<const uint8_t> mask) {
  check_pair(a, b);
  const size_t count = used_pixels(mask, a.data.size() / 3);
  int64_t sum = 0;
  for (size_t i = 0; i < a.data.size(); ++i) {
    if (!is_used(mask, i / 3)) continue;
    const int difference = int(a.data[i]) - int(b.data[i]);
    sum += int64_t(difference) * difference;
  }
  return double(sum) / (255.0 * 255.0 * double(3 * count));
}

double psnr_of_mse(double mse) {
  return mse > 0 ? std::min(-10.0 * std::log10(mse), kPsnrCap) : kPsnrCap;
}

double psnr(const Image8& a, const Image8& b) {
  return psnr_of_mse(mean_squared_error(a, b));
}

double psnr_float(Span<const float> planar_rgb, const Image8& truth, Span<const uint8_t> mask) {
  const size_t pixels = truth.data.size() / 3;
  check(truth.channels == 3 && pixels > 0 && planar_rgb.size == int64_t(3 * pixels),
        "psnr_float: [3, height, width] floats and an RGB image of that size");
  double sum = 0;
  for (size_t c = 0; c < 3; ++c)
    for (size_t p = 0; p < pixels; ++p) {
      if (!is_used(mask, p)) continue;
      const double difference =
          double(clamped(planar_rgb.data[c * pixels + p])) - truth.data[3 * p + c] / 255.0;
      sum += difference * difference;
    }
  return psnr_of_mse(sum / (3.0 * double(used_pixels(mask, pixels))));
}

}  // namespace tessera
