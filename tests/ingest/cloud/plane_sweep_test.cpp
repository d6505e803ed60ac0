// The plane sweep on a textured wall of known depth.
#include "ingest/cloud/plane_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/ingest/cloud/wall_scene.h"

namespace tessera::testing {
namespace {

/// From every third pixel of all frames.
std::vector<SweptPoint> swept(const Scene& scene) {
  const PlaneSweep sweep(scene);
  std::vector<SweptPoint> points;
  for (int frame : sweep.frames())
    for (int y = 0; y < scene.frames[size_t(frame)].image.height; y += 3)
      for (int x = 0; x < scene.frames[size_t(frame)].image.width; x += 3)
        for (const SweptPoint& point : sweep.find({{frame, x, y}})) points.push_back(point);
  return points;
}

/// Share of points off the wall by more than `bound`.
double share_off(const std::vector<SweptPoint>& points, double bound) {
  int64_t off = 0;
  for (const SweptPoint& point : points) off += std::abs(point.position.z - kWallDepth) > bound;
  return double(off) / double(points.size());
}

// Bugs put back: the eye left out of the lines' b; planes not refined; each seen to fail.
TEST(PlaneSweep, FindsTheWallBetweenPlanes) {
  const std::vector<SweptPoint> points = swept(wall_scene());
  ASSERT_GT(points.size(), 3000u) << "of 10,240 pixels";
  // patches at the border of two patterns may be wrong; the bulk may not. Planes are 0.22 apart.
  EXPECT_LT(share_off(points, 0.05), 0.03);
  for (const SweptPoint& point : points)
    EXPECT_NEAR(point.pixel, point.position.z / 96, 0.1 * point.pixel);
}

// Bug put back: `still` compares the image with itself; seen to fail.
TEST(PlaneSweep, DetectsMovingPoints) {
  int64_t moving = 0;
  for (const SweptPoint& point : swept(wall_scene())) {
    moving += !point.still;
    if (std::abs(point.position.x - kWallMoves) < 0.2) continue;  // both in a patch
    EXPECT_EQ(point.still, point.position.x < kWallMoves) << point.position.x;
  }
  EXPECT_GT(moving, 100);
}

// Bug put back: the light of images left out; seen to fail.
TEST(PlaneSweep, WhatIsStillStaysSoWhereTheLightChanges) {
  Scene scene = wall_scene({.timesteps = 3});
  for (Frame& frame : scene.frames)
    if (frame.frame_number > 0)
      for (size_t i = 0; i < frame.image.data.size(); ++i)
        frame.image.data[i] = uint8_t(frame.image.data[i] * (i % 3 == 0 ? 0.9 : 0.75));
  int64_t still = 0, moving = 0;
  for (const SweptPoint& point : swept(scene)) {
    if (std::abs(point.position.x - kWallMoves) < 0.2) continue;  // both in a patch
    (point.still ? still : moving) += 1;
    EXPECT_EQ(point.still, point.position.x < kWallMoves) << point.position.x;
  }
  EXPECT_GT(still, 1000);
  EXPECT_GT(moving, 100);
}

/// The wall stands still; what passes before a quarter of it is red.
std::array<uint8_t, 3> passing(int, double x, double y, double time) {
  if (x < -0.3 && time > 0.4 && time < 0.6) return {200, 10, 10};
  return wall_colour(std::min(x, kWallMoves), y, 0);
}

// Bug put back: a single timestep that differs is enough; seen to fail.
TEST(PlaneSweep, SomethingMayPassBeforeWhatIsStill) {
  const Scene scene = wall_scene({.timesteps = 9, .colour = passing});
  const PlaneSweep sweep(scene);
  int64_t behind = 0;
  for (int frame : sweep.frames())
    for (int y = 6; y < 90; y += 12)
      for (int x = 6; x < 90; x += 12) {
        const double time = scene.frames[size_t(frame)].time;
        const bool in_passing = time > 0.4 && time < 0.6;
        if (in_passing) continue;
        EXPECT_FALSE(sweep.moves({frame, x, y})) << frame << ": " << x << ", " << y;
        ++behind;
      }
  EXPECT_GT(behind, 500);
}

// Bug put back: patches keep their mean; seen to fail.
TEST(PlaneSweep, CamerasMayDifferInBrightness) {
  Scene scene = wall_scene();
  const double equal = double(swept(scene).size());
  for (Frame& frame : scene.frames)
    if (frame.camera_name == "cam1" || frame.camera_name == "cam3")
      for (uint8_t& level : frame.image.data) level = uint8_t(std::min(255, level * 6 / 5));
  const std::vector<SweptPoint> points = swept(scene);
  EXPECT_GT(double(points.size()), 0.8 * equal);
  EXPECT_LT(share_off(points, 0.05), 0.03);
}

void fill_mask(Frame& frame, int used_from_x) {
  Image8 mask{frame.image.width, frame.image.height, 1, {}};
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) mask.data.push_back(x >= used_from_x ? 255 : 0);
  frame.mask = std::move(mask);
}

// B17. Bug put back: ignored pixels searched for; seen to fail.
TEST(PlaneSweep, MaskedPixelsGiveNoPointAndHaveNoEffect) {
  Scene scene = wall_scene({.timesteps = 1});
  fill_mask(scene.frames[2], 48);
  const auto count = [&](int begin, int end) {
    const PlaneSweep sweep(scene);
    int64_t found = 0;
    for (int y = 4; y < 92; y += 4)
      for (int x = begin; x < end; x += 4) found += int64_t(sweep.find({{2, x, y}}).size());
    return found;
  };
  EXPECT_EQ(count(0, 48), 0);
  EXPECT_GT(count(48, 96), 50) << "of 264";
  for (const size_t other : {0u, 1u, 3u, 4u}) fill_mask(scene.frames[other], 96);
  EXPECT_EQ(count(48, 96), 0);
}

/// Repeats every 0.4 units of x. The third camera sees it half a period off.
std::array<uint8_t, 3> repeating(int camera, double x, double y, double) {
  if (camera == 2) x += 0.2;
  std::array<uint8_t, 3> rgb;
  for (size_t c = 0; c < 3; ++c) {
    const double turn = 2 * 3.14159265358979 * x / 0.4, phase = 1.7 * double(c);
    rgb[c] = uint8_t(127.5 + 40 * std::sin(turn + 5 * y + phase) +
                     40 * std::sin(2 * turn - 9 * y + 2 * phase));
  }
  return rgb;
}

// At half the wall's depth its neighbours on either side agree with the third camera, by half a
// period each. They themselves do not, because the other cameras contradict it.
// Bug put back: confirmed() always true; seen to fail.
TEST(PlaneSweep, TheOtherCameraMustConsent) {
  const Scene scene = wall_scene({.timesteps = 1, .focus = 3.6, .colour = repeating});
  const PlaneSweep sweep(scene);
  int64_t found = 0;
  for (int y = 3; y < 93; ++y)  // in the middle, which all cameras see at all depths
    for (int x = 36; x < 60; ++x) found += int64_t(sweep.find({{2, x, y}}).size());
  // of 2,160 pixels; by chance a few agree both ways (317 do; 1,570 without the check)
  EXPECT_LT(found, 500);
}

TEST(PlaneSweep, NeedsThreeTrainingCamerasOfATimestep) {
  EXPECT_TRUE(PlaneSweep(wall_scene({.cameras = 2})).frames().empty());
  Scene scene = wall_scene({.cameras = 3});
  EXPECT_EQ(PlaneSweep(scene).frames().size(), 6u);
  for (Frame& frame : scene.frames)
    if (frame.camera_name == "cam0") frame.split = Split::kTest;
  EXPECT_TRUE(PlaneSweep(scene).frames().empty());
}

}  // namespace
}  // namespace tessera::testing
