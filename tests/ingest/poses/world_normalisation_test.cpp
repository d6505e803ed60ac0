// Up direction, centre and scale of rigs with known answers, with outliers, and of degenerate rigs.
// Models in the normalised world are tested in tests/static3d/transform/world_change_test.cpp.
#include "ingest/poses/world_normalisation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kernels/math/rotation3.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/support/random.h"

namespace tessera::testing {
namespace {

constexpr double kPi = 3.14159265358979323846;

Camera camera_of(const Stand& stand) {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fl_x = camera.fl_y = 60;
  camera.cx = 32;
  camera.cy = 24;
  camera.cam_from_world = glm::transpose(glm::dmat3(stand.right, -stand.up, stand.forward));
  camera.translation = -(camera.cam_from_world * stand.centre);
  return camera;
}

/// Cameras on an arc about the origin that look down on it at an elevation, +z up.
std::vector<Camera> arc(int count, double radius, double elevation, double span) {
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double angle = span * i / (count - 1);
    cameras.push_back(camera_of(looking_at_origin({radius * std::cos(elevation) * std::cos(angle),
                                                   radius * std::cos(elevation) * std::sin(angle),
                                                   radius * std::sin(elevation)})));
  }
  return cameras;
}

Similarity some_world() {
  Similarity world;
  world.scale = 0.013;
  world.rotation = rotation_matrix(Vec4<double>(0.3, -0.8, 0.4, 0.2));
  world.translation = {5, -7, 3};
  return world;
}

std::vector<Camera> in_world(const Similarity& world, std::vector<Camera> cameras) {
  for (Camera& camera : cameras) camera = camera_in_world(world, camera);
  return cameras;
}

/// The normalisation of the cameras put into another world leads back, but for the azimuth.
void expect_found(const std::vector<Camera>& cameras, double radius, double tolerance) {
  const Similarity world = some_world();
  const Similarity found = normalised_from_source(in_world(world, cameras), {});
  const Similarity both = compose(found, world);  // from the world in which the answer is known
  EXPECT_NEAR(both.scale, 4 / radius, tolerance);
  EXPECT_LT(glm::length(both.translation), 4 * tolerance);
  EXPECT_LT(glm::distance(both.rotation[2], glm::dvec3(0, 0, 1)), tolerance);
}

// Bug put back: mean of the up axes on an arc (tilted by the elevation); seen to fail.
TEST(WorldNormalisation, ArcThatLooksDownIsUpright) {
  expect_found(arc(12, 2.5, 0.6, 1.9), 2.5, 1e-9);
  expect_found(arc(40, 70, 0.2, 2 * kPi * 39 / 40), 70, 1e-9);
}

// Bug put back: least squares instead of the reweighted centre; seen to fail.
TEST(WorldNormalisation, OneCameraOfTenThatLooksAsideMovesLittle) {
  std::vector<Camera> cameras = arc(10, 3, 0.3, 2.5);
  glm::dmat3 turn(std::cos(0.5), std::sin(0.5), 0, -std::sin(0.5), std::cos(0.5), 0, 0, 0, 1);
  cameras[4].translation = turn * cameras[4].translation;
  cameras[4].cam_from_world = turn * cameras[4].cam_from_world;  // rolled about its axis
  cameras[7] = camera_of(looking_at_origin({2, 0.5, 0.1}));
  cameras[7].translation += glm::dvec3(1.5, 0, 0);  // its axis misses the centre by 1.5
  const Similarity found = normalised_from_source(cameras, {});
  EXPECT_NEAR(found.scale, 4.0 / 3, 1e-3);
  EXPECT_LT(glm::length(found.translation), 1e-3);
}

TEST(WorldNormalisation, ParallelAxesTakeTheDepthOfThePoints) {
  std::vector<Camera> cameras;
  PointCloud points;
  for (int i = 0; i < 5; ++i) {
    Stand stand = looking_at_origin({10, 0, 0});
    stand.centre += glm::dvec3(0, 0.3 * (i - 2), 0);
    cameras.push_back(camera_of(stand));
  }
  for (int i = 0; i < 41; ++i)  // depth 6 to 10, median 8; and outliers beyond all
    points.position.push_back({float(4 - 0.1 * i), 0, 0});
  points.position.push_back({-1e6f, 0, 0});
  points.position.push_back({1e6f, 1e6f, 0});
  const Similarity found = normalised_from_source(cameras, points);
  EXPECT_NEAR(found.scale, 0.5, 0.01);
  EXPECT_LT(glm::distance(found({2, 0, 0}), glm::dvec3(0)), 0.1);
  EXPECT_LT(glm::distance(found.rotation[2], glm::dvec3(0, 0, 1)), 1e-9);
}

// Bug put back: scale by the cameras alone; seen to fail.
TEST(WorldNormalisation, PointsBeforeTheNearPlaneEnlarge) {
  const std::vector<Camera> cameras = arc(12, 4, 0.3, 2);
  PointCloud points;
  for (const Camera& camera : cameras)
    for (int i = 0; i < 5; ++i)
      points.position.push_back(
          glm::vec3(camera.position() + 0.1 * glm::transpose(camera.cam_from_world)[2]));
  EXPECT_NEAR(normalised_from_source(cameras, points).scale, 3, 0.01);  // 0.1 → 0.3
  points.position.resize(1);
  for (int i = 0; i < 400; ++i) points.position.push_back({0, 0, 0});
  EXPECT_NEAR(normalised_from_source(cameras, points).scale, 1, 0.01);  // a speck before one lens
}

TEST(WorldNormalisation, UpSideDownAndAlone) {
  std::vector<Camera> cameras = arc(8, 4, 0.2, 2);
  Similarity flip;
  flip.rotation = glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1);
  const Similarity found = normalised_from_source(in_world(flip, cameras), {});
  EXPECT_LT(glm::distance(found.rotation[2], glm::dvec3(0, 0, -1)), 1e-9);
  EXPECT_NEAR(glm::determinant(found.rotation), 1, 1e-12);
  const Similarity alone = normalised_from_source({cameras[0]}, {});
  EXPECT_EQ(alone.scale, 1);
  EXPECT_TRUE(std::isfinite(glm::length(alone.translation)));
}

}  // namespace
}  // namespace tessera::testing
