// Mean squared distance to the three nearest neighbours from all pairs, in double. It is the
// reference for recon4d/training/nearest_points.h.
#pragma once
#include <algorithm>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera::testing {

inline std::vector<float> brute_force_distance(const std::vector<glm::vec3>& points) {
  std::vector<float> result;
  for (size_t i = 0; i < points.size(); ++i) {
    std::vector<double> squared;
    for (size_t j = 0; j < points.size(); ++j) {
      const glm::dvec3 d = glm::dvec3(points[j]) - glm::dvec3(points[i]);
      if (j != i) squared.push_back(d.x * d.x + d.y * d.y + d.z * d.z);
    }
    std::sort(squared.begin(), squared.end());
    squared.resize(std::min<size_t>(squared.size(), 3));
    double sum = 0;
    for (double s : squared) sum += s;
    result.push_back(squared.empty() ? 0 : float(sum / double(squared.size())));
  }
  return result;
}

}  // namespace tessera::testing
