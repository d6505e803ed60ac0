// What: the two forms of dynamic Gaussians into each other: both describe the same family.
// Not: which form a training uses (TrainOptions::motion).
#pragma once
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// A dynamic set stored in `form` (kPair or kVelocity); values only, no optimizer state. It renders
/// as before to rounding. Unsound Gaussians (recon4d/model/element_edits.h) are left out.
GaussianSet in_form(const GaussianSet& dynamic_set, SetForm form);

}  // namespace tessera
