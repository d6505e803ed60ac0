// What: the plane sweep on a textured wall whose depth is known, part of which changes over time.
// Not: its share in the initial Gaussians (train_initialise_test.cpp).
#include <gtest/gtest.h>

#include <cmath>

#include "recon4d/plane_sweep.h"

namespace tessera {
namespace {

constexpr double kDepth = 3;  // of the wall, world units
constexpr int kSize = 96;     // pixels

/// Colour of the wall at (x, y): waves of several lengths, so that no two places look the same.
/// Right of x = 0.3 the pattern moves with time.
std::array<uint8_t, 3> wall(double x, double y, double time) {
  if (x > 0.3) x += time;
  std::array<uint8_t, 3> rgb;
  for (size_t c = 0; c < 3; ++c) {
    const double phase = double(c) * 1.7;
    const double wave = std::sin(9 * x + 4 * y + phase) + std::sin(23 * y - 7 * x + 2 * phase) +
                        std::sin(31 * x + 17 * y - phase);
    rgb[c] = uint8_t(127.5 + 40 * wave);
  }
  return rgb;
}

/// Cameras at x = −0.4 … 0.4 looking along +z at the wall, two moments each. One more camera looks
/// at a point in front of them all, which sets the rig's focus.
Scene wall_scene(int cameras) {
  Scene scene;
  for (int k = 0; k < cameras; ++k)
    for (double time : {0.0, 1.0}) {
      Frame frame;
      frame.camera.width = frame.camera.height = kSize;
      frame.camera.fl_x = frame.camera.fl_y = kSize;
      frame.camera.cx = frame.camera.cy = kSize / 2.0;
      const double x = cameras > 1 ? -0.4 + 0.8 * k / (cameras - 1) : 0;
      frame.camera.translation = {-x, 0, 0};
      frame.camera_name = "cam" + std::to_string(k);
      frame.name = frame.camera_name + "/" + std::to_string(int(time));
      frame.time = time;
      frame.image = {kSize, kSize, 3, {}};
      for (int v = 0; v < kSize; ++v)
        for (int u = 0; u < kSize; ++u) {
          const double wx = x + (u + 0.5 - kSize / 2.0) / kSize * kDepth;
          const double wy = (v + 0.5 - kSize / 2.0) / kSize * kDepth;
          for (uint8_t level : wall(wx, wy, time)) frame.image.data.push_back(level);
        }
      scene.frames.push_back(frame);
    }
  return scene;
}

CameraRig rig_of(const Scene& scene) {
  CameraRig rig = make_camera_rig(scene);
  rig.distance = 2.5;  // parallel axes have no focus of their own
  return rig;
}

// Bug put back: the camera's translation not taken out in `on_ray`; seen to fail.
TEST(TrainSweep, FindsTheWall) {
  const Scene scene = wall_scene(5);
  const std::vector<SweptPoint> points = plane_sweep(scene, rig_of(scene), 2000, 1);
  ASSERT_GT(points.size(), 500u);
  int64_t near = 0;
  for (const SweptPoint& point : points) near += std::abs(point.position.z - kDepth) < 0.1;
  // patches at the border of two patterns may be wrong; the bulk may not
  EXPECT_GT(double(near), 0.95 * double(points.size()));
}

// Bug put back: `still` compares the picture with itself; seen to fail.
TEST(TrainSweep, TellsWhatMoves) {
  const Scene scene = wall_scene(5);
  for (const SweptPoint& point : plane_sweep(scene, rig_of(scene), 2000, 1)) {
    if (std::abs(point.position.x - 0.3f) < 0.2f) continue;  // patches that hold both parts
    EXPECT_EQ(point.still, point.position.x < 0.3f) << point.position.x;
  }
}

TEST(TrainSweep, NeedsThreeCamerasOfAMoment) {
  const Scene scene = wall_scene(2);
  EXPECT_TRUE(plane_sweep(scene, rig_of(scene), 500, 1).empty());
}

TEST(TrainSweep, SameSeedSamePoints) {
  const Scene scene = wall_scene(4);
  const auto first = plane_sweep(scene, rig_of(scene), 500, 7);
  const auto again = plane_sweep(scene, rig_of(scene), 500, 7);
  const auto other = plane_sweep(scene, rig_of(scene), 500, 8);
  ASSERT_EQ(first.size(), again.size());
  for (size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].position, again[i].position);
  ASSERT_FALSE(other.empty());
  EXPECT_NE(first[0].position, other[0].position);
}

}  // namespace
}  // namespace tessera
