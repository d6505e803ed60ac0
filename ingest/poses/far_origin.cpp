// Medians, so that one camera far away decides nothing.
#include "ingest/poses/far_origin.h"

#include <algorithm>

namespace tessera {
namespace {

double middle(std::vector<double> values) {
  const auto half = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  return *half;
}

}  // namespace

glm::dvec3 far_origin(const std::vector<glm::dvec3>& centres) {
  if (centres.size() < 2) return glm::dvec3(0);
  glm::dvec3 median;
  for (glm::length_t axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const glm::dvec3& centre : centres) values.push_back(centre[axis]);
    median[axis] = middle(std::move(values));
  }
  std::vector<double> distances;
  for (const glm::dvec3& centre : centres) distances.push_back(glm::length(centre - median));
  return far_origin(median, middle(std::move(distances)));
}

}  // namespace tessera
