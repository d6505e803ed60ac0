// Compositing is done on encoded sRGB values, as in the reference implementations, because scores
// depend on it. Masks take alpha or the brightest channel, cut at a threshold.
#include "ingest/images/alpha_and_mask.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr uint8_t kLargestIgnored = 127;
constexpr uint8_t kLargestNumber = 31;  // of objects; colours of DAVIS' palette are multiples of 32

bool has_transparent_pixels(const Image8& image) {
  if (image.channels != 4) return false;
  for (size_t i = 3; i < image.data.size(); i += 4)
    if (image.data[i] != 255) return true;
  return false;
}

/// The largest value of a mask without transparent pixels, and the largest difference of channels.
struct ValueRange {
  uint8_t largest = 0, colour = 0;
};

ValueRange range_of(const Image8& image) {
  ValueRange range;
  const auto channels = size_t(image.channels), colours = std::min<size_t>(channels, 3);
  for (size_t i = 0; i < image.data.size(); i += channels) {
    const auto [least, most] =
        std::minmax_element(image.data.data() + i, image.data.data() + i + colours);
    range.largest = std::max(range.largest, *most);
    range.colour = std::max(range.colour, uint8_t(*most - *least));
  }
  return range;
}

}  // namespace

Image8 composite_on(const Image8& image, const std::array<uint8_t, 3>& background) {
  check(image.channels == 1 || image.channels == 3 || image.channels == 4, "composite channels");
  if (image.channels == 3) return image;
  Image8 rgb{image.width, image.height, 3, {}};
  const size_t pixels = size_t(image.width) * size_t(image.height);
  rgb.data.resize(pixels * 3);
  for (size_t p = 0; p < pixels; ++p)
    for (size_t c = 0; c < 3; ++c) {
      if (image.channels == 1) {
        rgb.data[3 * p + c] = image.data[p];
        continue;
      }
      const float alpha = float(image.data[4 * p + 3]) / 255.0f;
      const float value = float(background[c]) * (1 - alpha) + float(image.data[4 * p + c]) * alpha;
      rgb.data[3 * p + c] = uint8_t(std::lround(value));
    }
  return rgb;
}

bool has_object_numbers(const Image8& image) {
  if (has_transparent_pixels(image)) return false;
  const ValueRange range = range_of(image);
  return range.colour > kLargestNumber || (range.largest > 0 && range.largest <= kLargestNumber);
}

Image8 mask_of_image(const Image8& image, const std::filesystem::path& file) {
  const bool by_alpha = has_transparent_pixels(image);
  const ValueRange range = by_alpha ? ValueRange{} : range_of(image);
  uint8_t ignored = kLargestIgnored;
  if (range.colour > kLargestNumber)
    ignored = kLargestNumber;
  else if (!by_alpha && range.largest <= kLargestNumber)
    ignored = 0;
  const auto channels = size_t(image.channels);
  Image8 mask{image.width, image.height, 1, {}};
  mask.data.resize(image.data.size() / channels);
  uint8_t largest = 0;
  for (size_t p = 0; p < mask.data.size(); ++p) {
    const uint8_t* pixel = image.data.data() + channels * p;
    const uint8_t value =
        by_alpha ? pixel[3] : *std::max_element(pixel, pixel + std::min<size_t>(channels, 3));
    largest = std::max(largest, value);
    mask.data[p] = value > ignored ? 255 : 0;
  }
  if (largest > 0 && largest <= ignored)
    throw InputError(fmt::format(
        "{}: the mask's largest value is {}, expected 0 for ignored and 255 for used pixels; "
        "multiply its values",
        file.string(), largest));
  return mask;
}

void check_mask_size(const Image8& mask, int width, int height, const std::filesystem::path& file) {
  if (mask.width == width && mask.height == height) return;
  throw InputError(
      fmt::format("{}: the mask is {}x{}, its image {}x{}; make the mask from that image",
                  file.string(), mask.width, mask.height, width, height));
}

void invert_mask(Image8& mask) {
  for (uint8_t& value : mask.data) value = uint8_t(255 - value);
}

}  // namespace tessera
