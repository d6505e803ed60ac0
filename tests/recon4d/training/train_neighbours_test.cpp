// Neighbour distances against all pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "recon4d/training/nearest_points.h"
#include "tests/recon4d/model/neighbour_distance.h"
#include "tests/support/random.h"

namespace tessera::testing {
namespace {

// Bug put back: the far side of a splitting plane is never searched; seen to fail.
TEST(NearestPoints, EqualsBruteForce) {
  Random random(4);
  for (int count : {0, 1, 2, 3, 4, 5, 8, 9, 17, 700}) {
    std::vector<glm::vec3> points;
    for (int i = 0; i < count; ++i)
      points.push_back({random.uniform(-1, 1), random.uniform(-3, 3), random.uniform(0, 0.01)});
    for (int i = 0; i + 1 < count / 10; ++i) points[size_t(i)] = points[size_t(count - 1)];
    const std::vector<float> found = mean_squared_neighbour_distance(points);
    const std::vector<float> expected = brute_force_distance(points);
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < found.size(); ++i)
      EXPECT_NEAR(found[i], expected[i], 1e-6 * expected[i]) << count << " points, " << i;
  }
}

// Bugs put back, each seen to fail: distances instead of their squares; a point left out of the
// others because of its number.
TEST(NearestPoints, OfOthers) {
  Random random(5);
  std::vector<glm::vec3> points, others;
  for (int i = 0; i < 60; ++i)
    points.push_back({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
  for (int i = 0; i < 400; ++i)
    others.push_back({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
  const std::vector<float> found = squared_distance_to_nearest(points, others);
  for (size_t i = 0; i < points.size(); ++i) {
    float least = 100;
    for (const glm::vec3& other : others) {
      const glm::vec3 d = other - points[i];
      least = std::min(least, d.x * d.x + d.y * d.y + d.z * d.z);
    }
    EXPECT_NEAR(found[i], least, 1e-6F) << i;
  }
  for (const float squared : squared_distance_to_nearest(others, others)) EXPECT_EQ(squared, 0);
  EXPECT_TRUE(std::isinf(squared_distance_to_nearest(points, {})[0]));
}

TEST(NearestPoints, PointsOnAGridAndOnOneSpot) {
  std::vector<glm::vec3> grid;
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; ++z) grid.push_back({2 * x, 2 * y, 2 * z});
  for (float squared : mean_squared_neighbour_distance(grid)) EXPECT_EQ(squared, 4);
  const std::vector<glm::vec3> spot(100, {1, 2, 3});
  for (float squared : mean_squared_neighbour_distance(spot)) EXPECT_EQ(squared, 0);
}

}  // namespace
}  // namespace tessera::testing
