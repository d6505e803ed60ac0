// The fixture's Gaussians carried by motion nodes.
#pragma once
#include "recon4d/model/gaussian_set.h"
#include "tests/support/random.h"

namespace tessera::testing {

/// From then on nodes that move and turn clearly carry the static set. Every tenth Gaussian has no
/// node and stays; the dynamic set is as before.
void carry_by_nodes(GaussianModel& model, Random& random);

}  // namespace tessera::testing
