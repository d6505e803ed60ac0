// Scenes whose image is known in closed form: no splat, one splat, two over a background, and one
// that crosses the near plane. Source: failure modes C1, C2, C9.
#include "tests/support/front_scene.h"

namespace tessera::testing {
namespace {

constexpr int kSize = kFrontSize, kMiddle = kFrontMiddle;
constexpr double kFocal = kFrontFocal;

double worst_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double worst = 0;
  for (size_t i = 0; i < a.size(); ++i) worst = std::max(worst, double(std::abs(a[i] - b[i])));
  return worst;
}

TEST(ClosedForm, ZeroGaussiansLeaveTheBackground) {  // C1
  // Bug put back: tiles without instances not stored; seen to fail.
  TestScene<float> scene = front_scene();
  scene.views.push_back(front_view());
  scene.options.background[1] = 0.25;
  scene.truth.assign(2, std::vector<uint8_t>(3 * kSize * kSize, 100));
  const Backward<float> result = backward(scene);
  EXPECT_EQ(result.bad, 0u);
  EXPECT_EQ(result.rendered.report.splats, 0);
  EXPECT_EQ(result.rendered.report.instances, 0);
  for (size_t i = 0; i < result.rendered.colour.size(); ++i)
    ASSERT_EQ(result.rendered.colour[i], i / (kSize * kSize) % 3 == 1 ? 0.25f : 0.0f);
  for (const float T : result.rendered.transmittance) ASSERT_EQ(T, 1.0f);
}

TEST(ClosedForm, OneSplatOnTheAxis) {  // C2
  // Bug put back: dilation 0.01; seen to fail.
  TestScene<float> scene = front_scene();
  add_round(scene, {0, 0, 5}, 0.3, 0.8, {0.9, 0.5, 0.1});
  const Rendered<float> r = render(scene);
  const double variance = std::pow(kFocal * 0.3 / 5, 2) + 0.3;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double square = std::pow(x - kMiddle, 2) + std::pow(y - kMiddle, 2);
      double alpha = 0.8 * std::exp(-square / (2 * variance));
      if (alpha < 1.0 / 255) alpha = 0;
      EXPECT_NEAR(front_pixel(r, 0, x, y), 0.9 * alpha, 1e-5);
      EXPECT_NEAR(front_pixel(r, 2, x, y), 0.1 * alpha, 1e-5);
    }
  EXPECT_NEAR(front_pixel(r, 0, kMiddle, kMiddle), 0.9 * 0.8, 1e-6);
}

TEST(ClosedForm, FaintSplatEndsWhereAlphaFallsTo255th) {  // C2
  // o = 0.01: the cut-off is at σ·√(2 ln 2.55) = 1.368 σ
  TestScene<float> scene = front_scene();
  add_round(scene, {0, 0, 5}, 0.5, 0.01, {1, 1, 1});
  const double reach = 1.3682 * std::sqrt(std::pow(kFocal * 0.5 / 5, 2) + 0.3);  // 5.52 pixels
  const Rendered<float> r = render(scene);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      EXPECT_EQ(front_pixel(r, 0, x, y) > 0, std::hypot(x - kMiddle, y - kMiddle) <= reach);
}

TEST(ClosedForm, TwoSplatsBlendFrontToBackWhateverTheirOrder) {
  for (const bool swap : {false, true}) {
    TestScene<float> scene = front_scene();
    scene.options.background[2] = 1;
    if (swap) add_round(scene, {0, 0, 6}, 0.3, 0.5, {0, 1, 0});
    add_round(scene, {0, 0, 4}, 0.3, 0.25, {1, 0, 0});
    if (!swap) add_round(scene, {0, 0, 6}, 0.3, 0.5, {0, 1, 0});
    const Rendered<float> r = render(scene);
    EXPECT_NEAR(front_pixel(r, 0, kMiddle, kMiddle), 0.25, 1e-6);
    EXPECT_NEAR(front_pixel(r, 1, kMiddle, kMiddle), 0.75 * 0.5, 1e-6);
    EXPECT_NEAR(front_pixel(r, 2, kMiddle, kMiddle), 0.75 * 0.5, 1e-6);
  }
}

TEST(ClosedForm, CrossingTheNearPlaneRemovesOneSplatAndNoMore) {  // C9
  TestScene<float> scene = front_scene();
  add_round(scene, {0.02, 0, 5}, 0.3, 0.5, {0.2, 0.9, 0.4});
  const Rendered<float> alone = render(scene);
  add_round(scene, {0.1, 0.1, 0.2001}, 0.004, 0.6, {1, 1, 1});
  const Rendered<float> before = render(scene);
  scene.fixed.at(kMean, 1)[2] = 0.1999f;
  EXPECT_EQ(render(scene).colour, alone.colour);
  // at z = near: centre 36.5 px is outside the image, σ² = (40·0.004/0.2)²(1 + 0.25) + 0.3
  EXPECT_LE(worst_difference(before.colour, alone.colour), 0.6 * std::exp(-0.5 * 16 / 1.1));
}

}  // namespace
}  // namespace tessera::testing
