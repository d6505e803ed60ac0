// The exact nearest neighbours of each point of a set. The cost grows faster than the number of
// points.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

struct Neighbour {
  float distance = 0;  // units of the points
  int32_t index = 0;
};

/// Of each point the `count` others that are nearest, ascending; fewer where there are fewer.
std::vector<std::vector<Neighbour>> nearest_few(const std::vector<glm::vec3>& points, int count);

}  // namespace tessera
