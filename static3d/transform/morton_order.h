// What: the order along a Morton curve, in which files of splats compress well.
// Not: the order on a device (Backend::locality_order).
#pragma once
#include <cstdint>
#include <vector>

#include "kernels/gaussians.h"

namespace tessera {

/// Elements by the Morton codes of their means in the box of all; equal codes keep their order.
std::vector<int64_t> morton_order(const GaussianSpans<const float>& set);

}  // namespace tessera
