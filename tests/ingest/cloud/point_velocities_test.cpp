// Velocities of points on a textured wall that slides and recedes, and points without a velocity.
// Solids before a background are tested in tests/recon4d/modes/modes_velocity_test.cpp.
#include "ingest/cloud/point_velocities.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "ingest/cloud/dense_cloud.h"
#include "ingest/cloud/nearest_few.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"
#include "tests/ingest/cloud/wall_scene.h"

namespace tessera::testing {
namespace {

/// The frames of some timesteps.
Scene part_of(const Scene& scene, const std::vector<int64_t>& timesteps) {
  Scene part;
  for (const Frame& frame : scene.frames)
    if (std::count(timesteps.begin(), timesteps.end(), frame.frame_number) > 0)
      part.frames.push_back(frame);
  return part;
}

struct Found {
  std::vector<SweptPoint> points;
  VelocityCount count;
};

/// At timestep `key`, whose neighbours are `around`.
Found found(const WallRig& rig, int64_t key, const std::vector<int64_t>& around) {
  const Scene scene = wall_scene(rig), here = part_of(scene, {0, key, rig.timesteps - 1});
  const PlaneSweep sweep(here);
  Found result{dense_points(sweep, {600, 1, {}}), {}};
  std::vector<SweptPoint*> of_key;
  for (SweptPoint& point : result.points)
    if (here.frames[size_t(point.frame)].frame_number == key) of_key.push_back(&point);
  std::vector<Scene> beside;  // a scene each
  for (const int64_t timestep : around) beside.push_back(part_of(scene, {timestep}));
  std::vector<const Scene*> scenes;
  for (const Scene& one : beside) scenes.push_back(&one);
  result.count = find_velocities(sweep, scenes, of_key);
  std::erase_if(result.points, [&](const SweptPoint& point) {
    return here.frames[size_t(point.frame)].frame_number != key;
  });
  return result;
}

/// Median of the relative errors of those whose velocity is not 0.
double median_error(const Found& made, const glm::vec3& truth) {
  std::vector<double> errors;
  for (const SweptPoint& point : made.points)
    if (!point.still && point.velocity != glm::vec3(0))
      errors.push_back(glm::distance(point.velocity, truth) / glm::length(truth));
  return errors.size() < 20 ? 1e9 : median(errors);
}

// The pattern slides by a world unit over the clip, 3.8 pixels a timestep.
// Bugs put back: the sign of `steps` of the frame before; velocities by timestep, not by clip; each
// seen to fail.
TEST(PointVelocities, OfAPatternThatSlides) {
  const Found made = found({.timesteps = 15, .size = 160}, 7, {6, 8});
  EXPECT_GT(made.count.moving, 30);
  // half by themselves, and more by their neighbours; the others lie near the border of the image
  // or of the pattern, or waves lead them astray. Bug put back: nothing is lent; seen to fail.
  EXPECT_GT(double(made.count.reliable), 0.85 * double(made.count.moving));
  EXPECT_LT(median_error(made, {-1, 0, 0}), 0.05);
  for (const SweptPoint& point : made.points)
    EXPECT_TRUE(!point.still || point.velocity == glm::vec3(0));
}

// At either end of a clip there is one frame beside.
TEST(PointVelocities, FromOneSide) {
  EXPECT_LT(median_error(found({.timesteps = 15, .size = 160}, 0, {1}), {-1, 0, 0}), 0.05);
  EXPECT_LT(median_error(found({.timesteps = 15, .size = 160}, 14, {13}), {-1, 0, 0}), 0.05);
}

// Along the cameras' axes, where only the baseline determines the velocity.
// Bug put back: derivatives by the camera's axes taken as those of the world; seen to fail.
TEST(PointVelocities, OfAWallThatRetreats) {
  const auto still = [](int, double x, double y, double) { return wall_colour(x, y, 0); };
  const Found made = found({.timesteps = 9, .retreat = 1, .colour = still}, 4, {3, 5});
  EXPECT_LT(median_error(made, {0, 0, 1}), 0.15);
}

// Bug put back: every displacement reliable; seen to fail.
TEST(PointVelocities, NoneWhereTheImagesBesideShowSomethingElse) {
  const auto flicker = [](int, double x, double y, double time) {
    const bool odd = std::lround(15 * time) % 2 == 1;
    return odd ? wall_colour(2 * y, 3 * x, 0) : wall_colour(x, y, 0);
  };
  const Found made = found({.timesteps = 16, .colour = flicker}, 7, {6, 8});
  EXPECT_GT(made.count.moving, 100);
  EXPECT_LT(made.count.reliable, made.count.moving / 10);
}

TEST(PointVelocities, TheSameOnAnyNumberOfThreads) {
  std::vector<std::vector<SweptPoint>> made;
  for (int threads : {1, 3}) {
    set_thread_count(threads);
    made.push_back(found({.timesteps = 15, .size = 160}, 7, {6, 8}).points);
  }
  set_thread_count(0);
  ASSERT_EQ(made[0].size(), made[1].size());
  for (size_t i = 0; i < made[0].size(); ++i) EXPECT_EQ(made[0][i].velocity, made[1][i].velocity);
}

// Bug put back: the search ends where one of the two sides does; seen to fail.
TEST(NearestFew, AsByLookingAtAll) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < 200; ++i)
    points.emplace_back(std::fmod(i * 0.37f, 1.0f), std::fmod(i * 0.73f, 1.3f),
                        std::fmod(i * 0.11f, 0.2f));
  const auto found_few = nearest_few(points, 5);
  for (size_t i = 0; i < points.size(); ++i) {
    std::vector<float> distances;
    for (size_t j = 0; j < points.size(); ++j)
      if (j != i) distances.push_back(glm::distance(points[i], points[j]));
    std::sort(distances.begin(), distances.end());
    ASSERT_EQ(found_few[i].size(), 5u);
    for (size_t k = 0; k < 5; ++k) EXPECT_FLOAT_EQ(found_few[i][k].distance, distances[k]);
  }
  EXPECT_EQ(nearest_few({{1, 2, 3}, {1, 2, 4}}, 5)[0].size(), 1u);
  EXPECT_TRUE(nearest_few({{1, 2, 3}}, 5)[0].empty());
}

}  // namespace
}  // namespace tessera::testing
