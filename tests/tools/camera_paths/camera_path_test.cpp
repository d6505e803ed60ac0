// Camera paths: closed forms of circle, spiral and spline, in a rotated world.
#include "tools/camera_paths/camera_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera::testing {
namespace {

using glm::dmat3;
using glm::dvec3;

constexpr double kPi = std::numbers::pi;
const dvec3 kCentre(3, -2, 5);
const dmat3 kTurn(glm::rotate(glm::dmat4(1), 0.7, glm::normalize(dvec3(1, 2, -1))));
const dvec3 kUp = kTurn[2];

Camera lens() {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fl_x = 70;
  camera.fl_y = 71;
  camera.cx = 31;
  camera.cy = 25;
  return camera;
}

dvec3 forward_of(const Camera& camera) {
  return glm::transpose(camera.cam_from_world)[2];
}

Camera camera_at(const dvec3& position, const dvec3& target, const dvec3& up) {
  Camera camera = lens();
  const dvec3 forward = glm::normalize(target - position);
  const dvec3 right = glm::normalize(glm::cross(forward, up));
  camera.cam_from_world = glm::transpose(dmat3(right, glm::cross(forward, right), forward));
  camera.translation = -(camera.cam_from_world * position);
  return camera;
}

/// Cameras at kTurn·(radius, angle, height) about kCentre that look at it.
std::vector<Camera> ring(int count, double radius, double height, double from, double to) {
  std::vector<Camera> rig;
  for (int i = 0; i < count; ++i) {
    const double angle = from + (to - from) * i / count;
    const dvec3 arm = kTurn * dvec3(radius * std::cos(angle), radius * std::sin(angle), height);
    rig.push_back(camera_at(kCentre + arm, kCentre, kUp));
  }
  return rig;
}

void expect_near(const dvec3& a, const dvec3& b, double bound, const char* what) {
  EXPECT_LT(glm::length(a - b), bound) << what;
}

// Bugs put back, each seen to fail: height left out; radius from the centre in place of the axis;
// the camera's y axis up.
TEST(CameraPath, OrbitLooksAtTheCentreFromACircle) {
  const OrbitFrame frame = orbit_of_rig(ring(12, 4, 1.5, 0, 2 * kPi), {});
  expect_near(frame.centre, kCentre, 1e-6, "centre");
  expect_near(frame.up, kUp, 1e-6, "up");
  EXPECT_NEAR(frame.radius, 4, 1e-6);
  EXPECT_NEAR(frame.height, 1.5, 1e-6);
  const std::vector<Camera> path = orbit_path(frame, lens(), 90);
  ASSERT_EQ(path.size(), 90u);
  for (size_t i = 0; i < path.size(); ++i) {
    const dvec3 arm = path[i].position() - kCentre;
    const double above = glm::dot(arm, kUp);
    EXPECT_NEAR(above, 1.5, 1e-6);
    EXPECT_NEAR(glm::length(arm - above * kUp), 4, 1e-6);
    expect_near(forward_of(path[i]), -glm::normalize(arm), 1e-6, "looks at the centre");
    const dmat3 axes = glm::transpose(path[i].cam_from_world);
    EXPECT_LT(glm::dot(axes[1], kUp), -0.9) << "y is down";
    EXPECT_NEAR(glm::dot(axes[0], kUp), 0, 1e-9) << "level";
    EXPECT_NEAR(glm::determinant(path[i].cam_from_world), 1, 1e-12);
    EXPECT_EQ(path[i].fl_y, 71);
    const dvec3 step = path[(i + 1) % 90].position() - path[i].position();
    EXPECT_NEAR(glm::length(step), 2 * 4 * std::sin(kPi / 90), 1e-9) << "the last, too";
  }
}

// Bug put back: start at any side; seen to fail.
TEST(CameraPath, OrbitBeginsWhereTheRigIs) {
  const std::vector<Camera> arc = ring(7, 4, 0, 1.0, 1.7);
  const Camera first = orbit_path(orbit_of_rig(arc, {}), lens(), 8).front();
  expect_near(first.position(), arc[3].position(), 0.02, "the arc's middle");
}

// Bug put back: the tangent of half the angle in place of its sine; seen to fail.
TEST(CameraPath, OrbitWithoutARigSeesTheWholeSphere) {
  const OrbitFrame frame = orbit_of_box(kCentre, 2, kUp, lens());
  for (const Camera& camera : orbit_path(frame, lens(), 5)) {
    const double distance = glm::length(camera.position() - kCentre);
    EXPECT_NEAR(std::sin(std::atan(24 / 71.0)) * distance, 2, 1e-9);
    EXPECT_GT(glm::dot(camera.position() - kCentre, kUp), 0);
  }
}

// Bugs put back, each seen to fail: one and a half turns in place of two (does not close); the
// reach squared.
TEST(CameraPath, SpiralStaysWithinTheRigAndCloses) {
  const std::vector<Camera> rig = ring(9, 6, 0.4, -0.5, 0.5);
  dvec3 mean(0.0);
  dvec3 high(0.0);
  dvec3 forward(0.0);
  for (const Camera& camera : rig) {
    mean += camera.position() / 9.0;
    forward += forward_of(camera) / 9.0;
  }
  const dmat3 axes = camera_at(mean, mean + forward, kUp).cam_from_world;
  for (const Camera& camera : rig) {
    const dvec3 offset = glm::abs(axes * (camera.position() - mean));
    high = glm::max(high, offset);
  }
  const std::vector<Camera> path = spiral_path(rig, {}, lens(), 60);
  ASSERT_EQ(path.size(), 60u);
  double widest = 0;
  for (size_t i = 0; i < path.size(); ++i) {
    const dvec3 offset = axes * (path[i].position() - mean);
    for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(offset[k]), high[k] + 1e-9) << i;
    widest = std::max(widest, std::abs(offset.x));
    EXPECT_LT(glm::dot(glm::transpose(path[i].cam_from_world)[1], kUp), -0.9);
    const dvec3 step = path[(i + 1) % 60].position() - path[i].position();
    EXPECT_LT(glm::length(step), 0.5 * glm::length(high)) << "the last, too";
    // all look at one point, near the centre that the rig looks at
    const dvec3 to_centre = kCentre - path[i].position();
    EXPECT_GT(glm::dot(forward_of(path[i]), glm::normalize(to_centre)), 0.99);
  }
  EXPECT_GT(widest, 0.5 * high.x) << "it does move";
}

// Bug put back: the mean of whole directions, by which a dome that looks down looks one way; seen
// to fail.
TEST(CameraPath, ARigThatLooksOneWayIsKnown) {
  EXPECT_TRUE(looks_one_way(ring(6, 4, 1, 0, kPi / 2), kUp));
  EXPECT_FALSE(looks_one_way(ring(12, 4, 1.5, 0, 2 * kPi), kUp));
  EXPECT_FALSE(looks_one_way(ring(12, 1, 4, 0, 2 * kPi), kUp)) << "from above";
}

TEST(CameraPath, SpiralsNeedARigThatLooksOneWay) {
  expect_input_error([] { spiral_path(ring(12, 4, 1, 0, 2 * kPi), {}, lens(), 5); },
                     {"--path spiral", "--path orbit"});
  const std::vector<Camera> alone(3, ring(1, 4, 1, 0, 1).front());
  PointCloud points;
  points.position = {glm::vec3(kCentre)};
  expect_input_error([&] { spiral_path(alone, points, lens(), 5); }, {"stand in one place"});
  std::vector<Camera> parallel;
  for (int i = 0; i < 3; ++i)
    parallel.push_back(camera_at(dvec3(i, 0, 0), dvec3(i, 9, 0), dvec3(0, 0, 1)));
  expect_input_error([&] { spiral_path(parallel, {}, lens(), 5); }, {"nothing lies before"});
  points.position = {{1, 9, 0}};
  EXPECT_EQ(spiral_path(parallel, points, lens(), 5).size(), 5u);
  std::vector<Camera> down = alone;
  for (Camera& camera : down) camera = camera_at(dvec3(0, 0, 4), dvec3(0), dvec3(0, 1, 0));
  expect_input_error([&] { orbit_of_rig(down, {}); }, {"--path orbit"});
}

// Bugs put back, each seen to fail: the end of the path one step short of the last key; slerp the
// long way (the quaternion of the next key not negated).
TEST(CameraPath, KeysAreHitAndBetweenThemItIsSmooth) {
  std::vector<Camera> keys = ring(5, 4, 1, 0, 2 * kPi);
  keys[2].fl_x = 90;
  const std::vector<Camera> path = key_path(keys, 41);
  ASSERT_EQ(path.size(), 41u);
  for (size_t k = 0; k < 5; ++k) EXPECT_TRUE(path[10 * k] == keys[k]) << k;
  EXPECT_NEAR(path[15].fl_x, 80, 1e-9) << "between the second and the third";
  for (size_t i = 0; i + 1 < path.size(); ++i) {
    EXPECT_NEAR(glm::determinant(path[i].cam_from_world), 1, 1e-9);
    const double cosine = glm::dot(forward_of(path[i]), forward_of(path[i + 1]));
    EXPECT_GT(cosine, std::cos(0.2)) << "a tenth of 72 degrees, not the long way; " << i;
  }
  EXPECT_EQ(key_path(keys, 5).size(), 5u);
  for (size_t k = 0; k < 5; ++k) EXPECT_TRUE(key_path(keys, 5)[k] == keys[k]);
  for (const Camera& camera : key_path({keys[1]}, 4)) EXPECT_TRUE(camera == keys[1]);
  EXPECT_TRUE(key_path(keys, 1).front() == keys.front());
}

// Centres on a straight line at even steps stay on it at even steps, ends included: the spline
// reproduces lines. Bug put back: the end keys doubled beyond the ends; seen to fail.
TEST(CameraPath, SplinesReproduceLines) {
  std::vector<Camera> keys;
  for (int k = 0; k < 4; ++k) keys.push_back(camera_at(dvec3(k, 2 * k, 0), dvec3(1, 30, 9), kUp));
  const std::vector<Camera> path = key_path(keys, 31);
  for (size_t i = 0; i < path.size(); ++i)
    expect_near(path[i].position(), dvec3(0.1, 0.2, 0) * double(i), 1e-9, "on the line");
}

// Bug put back: the principal point scaled with the width; seen to fail.
TEST(CameraPath, AnotherSizeKeepsTheVerticalFieldOfView) {
  const Camera wide = with_size(lens(), 192, 96);
  EXPECT_DOUBLE_EQ(wide.fl_y / wide.height, 71 / 48.0);
  EXPECT_DOUBLE_EQ(wide.fl_x / wide.fl_y, 70 / 71.0);
  EXPECT_DOUBLE_EQ(wide.cx - 96, 2 * (31 - 32.0));
  EXPECT_DOUBLE_EQ(wide.cy - 48, 2 * (25 - 24.0));
  EXPECT_TRUE(with_size(lens(), 64, 48) == lens());
}

}  // namespace
}  // namespace tessera::testing
