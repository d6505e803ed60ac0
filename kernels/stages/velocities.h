// What: velocities of a set on the host, before a backward pass changes any.
// Not: in project_backward.cpp: a second caller there of load_gaussian would keep it from being
// inlined, and the linker might take a copy in which products are contracted.
#pragma once
#include "kernels/gaussians.h"

namespace tessera {

/// v of each Gaussian of a dynamic set, [N, 3] world units per clip; see store_velocity.
template <class Real>
void find_velocities(const GaussianSpans<const Real>& set, Real* velocities);

}  // namespace tessera
