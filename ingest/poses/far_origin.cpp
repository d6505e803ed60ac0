// Medians, so that one camera far away decides nothing.
#include "ingest/poses/far_origin.h"

#include "kernels/base/median.h"

namespace tessera {

glm::dvec3 far_origin(const std::vector<glm::dvec3>& centres) {
  if (centres.size() < 2) return glm::dvec3(0);
  glm::dvec3 centre;
  for (glm::length_t axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const glm::dvec3& place : centres) values.push_back(place[axis]);
    centre[axis] = median_in_place(values);
  }
  std::vector<double> distances;
  for (const glm::dvec3& place : centres) distances.push_back(glm::length(place - centre));
  return far_origin(centre, median_in_place(distances));
}

}  // namespace tessera
