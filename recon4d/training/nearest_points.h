// Distances of points to their nearest neighbours, by a k-d tree. Source: initial scales, method
// A.2.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Mean squared distance of each point to its three nearest neighbours, world units²; with fewer
/// than four points, of those there are; one: 0.
std::vector<float> mean_squared_neighbour_distance(const std::vector<glm::vec3>& points);

/// Squared distance of each point to the nearest of `others`, world units²; infinity where there
/// are none.
std::vector<float> squared_distance_to_nearest(const std::vector<glm::vec3>& points,
                                               const std::vector<glm::vec3>& others);

}  // namespace tessera
