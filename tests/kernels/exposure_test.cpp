// Colour maps of images in the loss, in double: their gradient and that of opacities against
// central differences of the whole chain; the identity changes nothing. Source: failure mode B10.
#include "tests/support/colour_maps.h"
#include "tests/support/difference.h"

namespace tessera::testing {
namespace {

/// Images of several tiles, each with a map of its own; the truth keeps away from what is compared
/// with it.
TestScene<double> mapped_scene() {
  TestScene<double> scene = random_scene(5, 5, 0.25, 71);
  Random random(73);
  for (size_t b = 0; b < scene.views.size(); ++b) scene.maps.push_back(random_colour_map(random));
  keep_truth_away(scene, 72);
  return scene;
}

void expect_difference(double analytic, TestScene<double>& scene, double& parameter, double scale) {
  LossProbe probe(scene);
  const auto expected = difference(probe, scene, parameter, probe.at(scene).decisions);
  ASSERT_TRUE(expected.has_value());
  EXPECT_NEAR(analytic, *expected, 1e-6 * scale);
}

/// All nine numbers of dL/dA and three of dL/do of a view.
void expect_map_differences(const Backward<double>& analytic, TestScene<double>& scene, size_t view,
                            double scale) {
  const std::array<double, 12> gradient = numbers_of(std::as_const(analytic.d_maps[view]));
  const std::array<double*, 12> numbers = numbers_of(scene.maps[view]);
  for (size_t i = 0; i < numbers.size(); ++i) {
    SCOPED_TRACE(i);
    expect_difference(gradient[i], scene, *numbers[i], scale);
  }
}

double largest_of(const std::vector<double>& values) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

// Bugs put back, each seen to fail: A in the place of its transpose on the way back; dL/dA
// transposed; the gradient by the image as rendered taken for that by what is compared; maps of the
// next view; the last pixels left out of the sums.
TEST(Exposure, GradientsEqualDifferences) {
  TestScene<double> scene = mapped_scene();
  const Backward<double> analytic = backward(scene);
  ASSERT_EQ(analytic.d_maps.size(), 3u);
  for (size_t b = 0; b < 3; ++b) {
    const std::array<double, 12> d_map = numbers_of(analytic.d_maps[b]);
    const double largest = largest_of({d_map.begin(), d_map.end()});
    EXPECT_GT(largest, 1e-3);
    expect_map_differences(analytic, scene, b, largest);
  }
  std::vector<double>& logits = scene.fixed.group[kOpacityLogit];
  const double most = largest_of(analytic.fixed.group[kOpacityLogit]);
  EXPECT_GT(most, 1e-5);
  for (size_t n = 0; n < logits.size(); ++n)
    expect_difference(analytic.fixed.group[kOpacityLogit][n], scene, logits[n], most);
}

// Bugs put back, each seen to fail: the sums of the next view; the offset left out of the image.
TEST(Exposure, MaskedPixelsHaveNoEffect) {
  TestScene<double> scene = mapped_scene();
  scene.weights = {1, 0};  // as Gradient.WithMasksEqualsDifferences
  for (const View& view : scene.views)
    scene.mask.emplace_back(size_t(view.camera.width * view.camera.height), uint8_t{0});
  for (size_t i = 0; i < 300; ++i) scene.mask[0][2 * i] = 255;
  const Backward<double> analytic = backward(scene);
  expect_map_differences(analytic, scene, 0, 1e-2);
  EXPECT_GT(std::abs(analytic.d_maps[0].offset[1]), 1e-4);
  for (const double d : numbers_of(analytic.d_maps[1])) EXPECT_EQ(d, 0.0);
  EXPECT_EQ(analytic.losses[1].total, 0.0);
}

// Bug put back: an offset of 1e-4 added; seen to fail.
TEST(Exposure, IdentityIsNone) {
  TestScene<float> scene = mapped_scene().as<float>();
  scene.maps.clear();
  const Backward<float> without = backward(scene);
  scene.maps.resize(3);
  const Backward<float> with = backward(scene);
  EXPECT_TRUE(without.d_maps.empty());
  for (size_t b = 0; b < 3; ++b) EXPECT_EQ(with.losses[b].total, without.losses[b].total);
  for (int g = 0; g < kGroupCount; ++g)
    EXPECT_EQ(with.moving.group[g], without.moving.group[g]) << g;
}

}  // namespace
}  // namespace tessera::testing
