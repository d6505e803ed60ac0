// Ratios are those of a few ten thousand pixels, spread over the image.
#include "kernels/base/light_gain.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr size_t kPixels = 20000;            // that are looked at
constexpr size_t kLeastPixels = 100;         // that tell
constexpr uint8_t kDark = 16, kWhite = 245;  // 8-bit values, beyond which a ratio says little
constexpr double kLeastChange = 0.01;

}  // namespace

LightGain light_gain(const std::vector<uint8_t>& image, const std::vector<uint8_t>& reference) {
  check(image.size() == reference.size() && image.size() % 3 == 0,
        "light_gain: images of one size");
  const size_t pixels = image.size() / 3, apart = std::max<size_t>(1, pixels / kPixels);
  const auto tells = [](uint8_t value) { return value >= kDark && value <= kWhite; };
  LightGain gain = kSameLight;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<double> ratios;
    for (size_t i = c; i < image.size(); i += 3 * apart)
      if (tells(image[i]) && tells(reference[i]))
        ratios.push_back(double(image[i]) / double(reference[i]));
    if (ratios.size() < kLeastPixels) return kSameLight;
    gain[c] = median_in_place(ratios);
  }
  return is_same(gain) ? kSameLight : gain;
}

std::vector<uint8_t> times_light(const std::vector<uint8_t>& image, const LightGain& gain) {
  std::array<std::array<uint8_t, 256>, 3> table{};
  for (size_t c = 0; c < 3; ++c)
    for (size_t value = 0; value < 256; ++value)
      table[c][value] = uint8_t(std::min(std::lround(double(value) * gain[c]), 255L));
  std::vector<uint8_t> lit(image.size());
  for (size_t i = 0; i < image.size(); ++i) lit[i] = table[i % 3][image[i]];
  return lit;
}

bool is_same(const LightGain& gain) {
  return std::all_of(gain.begin(), gain.end(),
                     [](double factor) { return std::abs(factor - 1) < kLeastChange; });
}

LightGain inverse(const LightGain& gain) {
  return {1 / gain[0], 1 / gain[1], 1 / gain[2]};
}

}  // namespace tessera
