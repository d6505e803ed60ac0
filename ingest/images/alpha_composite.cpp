// What: the one place where alpha meets a background.
// Not: gamma-aware: the field composites encoded sRGB values, and scores depend on doing the same.
#include "ingest/images/alpha_composite.h"

#include <cmath>

#include "kernels/base/errors.h"

namespace tessera {

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

}  // namespace tessera
