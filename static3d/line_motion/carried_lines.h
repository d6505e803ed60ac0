// Gaussians that motion nodes carry, as lines (pieces.h).
#pragma once
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// A set of the form kVelocity, of the sound Gaussians of a canonical set.
GaussianSet lines_of_carried(const GaussianSet& canonical, const MotionNodes& nodes);

}  // namespace tessera
