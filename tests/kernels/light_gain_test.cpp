// How much lighter or darker one image of a place is than another.
#include "kernels/base/light_gain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tessera {
namespace {

using Image = std::vector<uint8_t>;

/// 60 × 40 pixels of all colours, with noise.
Image image_in(const LightGain& light, uint32_t seed, double noise = 4) {
  std::mt19937 colours(7), random(seed);
  std::normal_distribution<double> deviation(0, noise);
  Image image;
  for (int i = 0; i < 3 * 60 * 40; ++i) {
    const double value = double(colours() % 256) * light[size_t(i % 3)] + deviation(random);
    image.push_back(uint8_t(std::lround(std::clamp(value, 0.0, 255.0))));
  }
  return image;
}

// Bugs put back, each seen to fail: the mean of the ratios; black and white pixels that count; all
// channels alike.
TEST(LightGain, IsWhatMostPixelsHave) {
  const Image reference = image_in(kSameLight, 1);
  for (const LightGain& light :
       {LightGain{0.7, 0.8, 0.9}, LightGain{1.5, 1.2, 1}, LightGain{0.97, 1, 1}}) {
    Image image = image_in(light, 2);
    std::fill(image.begin(), image.begin() + int(image.size() / 4), uint8_t{180});  // something new
    const LightGain found = light_gain(image, reference);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[c], light[c], 0.03) << c;
  }
  EXPECT_EQ(light_gain(image_in({1.004, 0.996, 1}, 3), reference), kSameLight);
}

// Bug put back: too few pixels that tell, of which a median is taken; seen to fail.
TEST(LightGain, IsNotGuessed) {
  const Image black(3 * 60 * 40, 3), white(3 * 60 * 40, 255);
  EXPECT_EQ(light_gain(white, black), kSameLight);
  EXPECT_EQ(light_gain(white, white), kSameLight);
  Image few = black, brighter = black;
  std::fill_n(few.begin(), 30, uint8_t{100});
  std::fill_n(brighter.begin(), 30, uint8_t{150});
  EXPECT_EQ(light_gain(brighter, few), kSameLight);
}

TEST(LightGain, IsAppliedAndTakenBack) {
  const LightGain light = {0.5, 1, 2};
  EXPECT_EQ(times_light({100, 101, 102, 200, 201, 202}, light),
            (Image{50, 101, 204, 100, 201, 255}));
  EXPECT_EQ(times_light(times_light({100, 101, 102}, light), inverse(light)),
            (Image{100, 101, 102}));
}

}  // namespace
}  // namespace tessera
