// The origin that is taken out of the poses of a capture (kernels/base/far_origin.h).
#pragma once
#include <vector>

#include "kernels/base/far_origin.h"

namespace tessera {

/// Of places about the median of these camera centres, component by component, as far apart as the
/// median of their distances from it; 0 for fewer than two.
glm::dvec3 far_origin(const std::vector<glm::dvec3>& centres);

}  // namespace tessera
