// What: mean squared distance of each point to its three nearest neighbours, by a k-d tree.
// Not: a general search structure.
// Source: initial scales, method A.2.
#pragma once
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// One value per point, world units²; with fewer than four points, of those there are; one: 0.
std::vector<float> mean_squared_neighbour_distance(const std::vector<glm::vec3>& points);

}  // namespace tessera
