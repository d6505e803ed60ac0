// Gains of cameras measured on the points of a cloud.
#include "ingest/checks/colour_gains.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ingest/cloud/dense_cloud.h"
#include "tests/ingest/cloud/wall_scene.h"

namespace tessera::testing {
namespace {

/// The wall with its swept cloud, filmed by cameras with those gains; half as bright as it is, so
/// that no gain saturates.
Scene filmed_wall(const std::vector<std::array<double, 3>>& gains) {
  Scene scene = wall_scene({.cameras = int(gains.size()), .timesteps = 3});
  for (Frame& frame : scene.frames) {
    const auto& gain = gains[size_t(frame.camera_name.back() - '0')];
    for (size_t i = 0; i < frame.image.data.size(); ++i)
      frame.image.data[i] =
          uint8_t(std::clamp(std::lround(0.7 * frame.image.data[i] * gain[i % 3]), 0L, 255L));
  }
  scene.points = cloud_of(dense_points(PlaneSweep(scene), {600, 1, {}}));
  return scene;
}

// Bugs put back: the colour of one camera compared with that of another pixel; the gain of one
// channel used for all; each seen to fail.
TEST(ColourGains, AreMeasuredOnTheCloud) {
  std::vector<std::array<double, 3>> truth(5, {1, 1, 1});
  truth[1] = {1.1, 1.0, 0.95};
  truth[3] = {0.9, 0.92, 0.9};
  const std::vector<CameraGain> gains = measured_gains(filmed_wall(truth));
  ASSERT_EQ(gains.size(), 5u);
  for (size_t k = 0; k < 3; ++k) {
    double mean = 0;
    for (const auto& gain : truth) mean += gain[k] / 5;
    for (size_t c = 0; c < 5; ++c)
      EXPECT_NEAR(gains[c].gain[k] * mean / truth[c][k], 1, 0.015) << gains[c].camera << " " << k;
  }
  EXPECT_NEAR(largest_difference(gains), 0.11, 0.03);
}

TEST(ColourGains, OfEqualCamerasAreOne) {
  const std::vector<CameraGain> gains =
      measured_gains(filmed_wall(std::vector<std::array<double, 3>>(5, {1, 1, 1})));
  EXPECT_LT(largest_difference(gains), 0.01);
  for (const CameraGain& camera : gains) EXPECT_GT(camera.pairs, kLeastColourPairs);
}

TEST(ColourGains, WithoutACloudNothingIsMeasured) {
  Scene scene = filmed_wall(std::vector<std::array<double, 3>>(5, {1, 1, 1}));
  scene.points = {};
  for (const CameraGain& camera : measured_gains(scene)) EXPECT_EQ(camera.pairs, 0);
  EXPECT_EQ(largest_difference(measured_gains(scene)), 0);
}

}  // namespace
}  // namespace tessera::testing
