// What: nearest neighbours of points and their distances, by a k-d tree.
// Not: a general search structure.
// Source: initial scales, method A.2; rigidity, method D.8.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Mean squared distance of each point to its three nearest neighbours, world units²; with fewer
/// than four points, of those there are; one: 0.
std::vector<float> mean_squared_neighbour_distance(const std::vector<glm::vec3>& points);

struct Neighbour {
  int32_t point;
  float squared;  // distance, world units²
};

inline constexpr int kNeighbours = 20;  // k of the rigidity term  [Yang24]

/// The kNeighbours nearest of each point, nearest first; fewer where there are not as many.
std::vector<std::vector<Neighbour>> nearest_neighbours(const std::vector<glm::vec3>& points);

}  // namespace tessera
