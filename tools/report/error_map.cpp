// A scale from black by purple and orange to pale yellow: brighter is worse, for people with colour
// blindness and in print, too.
#include "tools/report/error_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using Colour = std::array<uint8_t, 3>;

// at equal distances
constexpr std::array<Colour, 5> kScale = {
    {{8, 8, 16}, {74, 24, 110}, {186, 54, 84}, {248, 140, 40}, {252, 248, 176}}};
constexpr Colour kIgnored = {128, 128, 128};

Colour colour_of(double error) {
  const double place = std::clamp(error / kLargestShownError, 0.0, 1.0) * double(kScale.size() - 1);
  const size_t i = std::min(size_t(place), kScale.size() - 2);
  const double share = place - double(i);
  Colour colour{};
  for (size_t c = 0; c < 3; ++c)
    colour[c] = uint8_t(std::lround((1 - share) * kScale[i][c] + share * kScale[i + 1][c]));
  return colour;
}

}  // namespace

Image8 error_map(const Image8& drawn, const Image8& truth, const Image8& mask) {
  check(drawn.width == truth.width && drawn.height == truth.height && drawn.channels == 3 &&
            truth.channels == 3,
        "an error map needs two RGB images of one size");
  Image8 map{truth.width, truth.height, 3, {}};
  map.data.resize(truth.data.size());
  for (size_t pixel = 0; 3 * pixel < map.data.size(); ++pixel) {
    int sum = 0;
    for (size_t c = 3 * pixel; c < 3 * pixel + 3; ++c)
      sum += std::abs(int(drawn.data[c]) - int(truth.data[c]));
    const bool used = mask.data.empty() || mask.data[pixel] != 0;
    const Colour colour = used ? colour_of(sum / 3.0) : kIgnored;
    std::copy(colour.begin(), colour.end(), map.data.begin() + std::ptrdiff_t(3 * pixel));
  }
  return map;
}

std::string error_scale_css() {
  std::string stops;
  for (const Colour& colour : kScale)
    stops += fmt::format(", rgb({},{},{})", colour[0], colour[1], colour[2]);
  return fmt::format("linear-gradient(to right{})", stops);
}

}  // namespace tessera
