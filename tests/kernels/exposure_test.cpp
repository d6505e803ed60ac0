// What: gains of the images in the loss, in double: their gradient and those of opacities behind
//       them against central differences of the whole chain; a gain of 1 is none.
// Not: what a training makes of them (tests/recon4d/model/train_exposure_test.cpp). Source: B10.
#include "tests/support/difference.h"

namespace tessera::testing {
namespace {

/// Images of several tiles, each with a gain of its own; the truth keeps away from what is
/// compared with it.
TestScene<double> gained_scene() {
  TestScene<double> scene = random_scene(5, 5, 0.25, 71);
  keep_truth_away(scene, 72);
  scene.gain = {{1.1, 0.9, 1.0}, {0.8, 1.0, 1.2}, {1.3, 0.95, 0.7}};
  return scene;
}

void expect_difference(double analytic, TestScene<double>& scene, double& parameter, double scale) {
  LossProbe probe(scene);
  const auto expected = difference(probe, scene, parameter, probe.at(scene).decisions);
  ASSERT_TRUE(expected.has_value());
  EXPECT_NEAR(analytic, *expected, 1e-6 * scale);
}

// Bugs put back, each seen to fail: the gradient by what is compared taken for that by the image;
// the gain's gradient multiplied by the gain; gains of another channel.
TEST(Exposure, GradientsEqualDifferences) {
  TestScene<double> scene = gained_scene();
  const Backward<double> analytic = backward(scene);
  ASSERT_EQ(analytic.d_gain.size(), 3u);
  double largest = 0;
  for (size_t b = 0; b < 3; ++b)
    for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(analytic.d_gain[b][c]));
  EXPECT_GT(largest, 1e-3);
  for (size_t b = 0; b < 3; ++b)
    for (int c = 0; c < 3; ++c)
      expect_difference(analytic.d_gain[b][c], scene, scene.gain[b][c], largest);
  double most = 0;
  for (const double d : analytic.fixed.group[kOpacityLogit]) most = std::max(most, std::abs(d));
  EXPECT_GT(most, 1e-5);
  for (size_t n = 0; n < scene.fixed.group[kOpacityLogit].size(); ++n)
    expect_difference(analytic.fixed.group[kOpacityLogit][n], scene,
                      scene.fixed.group[kOpacityLogit][n], most);
}

// Bug put back: gains of another channel; seen to fail.
TEST(Exposure, WhatAMaskIgnoresHasNoSay) {
  TestScene<double> scene = gained_scene();
  scene.weights = {1, 0};  // as Gradient.WithMasksEqualsDifferences
  for (const View& view : scene.views)
    scene.mask.emplace_back(size_t(view.camera.width * view.camera.height), uint8_t{0});
  for (size_t i = 0; i < 300; ++i) scene.mask[0][2 * i] = 255;
  const Backward<double> analytic = backward(scene);
  for (int c = 0; c < 3; ++c) {
    expect_difference(analytic.d_gain[0][c], scene, scene.gain[0][c], 1e-2);
    EXPECT_EQ(analytic.d_gain[1][c], 0.0);
  }
  EXPECT_EQ(analytic.losses[1].total, 0.0);
}

// Bug put back: gains 0.01 % off; seen to fail.
TEST(Exposure, OneIsNone) {
  TestScene<float> scene = gained_scene().as<float>();
  scene.gain.clear();
  const Backward<float> without = backward(scene);
  scene.gain.assign(3, Vec3<double>(1));
  const Backward<float> with = backward(scene);
  EXPECT_TRUE(without.d_gain.empty());
  for (size_t b = 0; b < 3; ++b) EXPECT_EQ(with.losses[b].total, without.losses[b].total);
  for (int g = 0; g < kGroupCount; ++g)
    EXPECT_EQ(with.moving.group[g], without.moving.group[g]) << g;
}

}  // namespace
}  // namespace tessera::testing
