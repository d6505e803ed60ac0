// Conversion between the two forms of dynamic Gaussians, which describe the same family.
#pragma once
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// A dynamic set stored in `form` (kPair or kVelocity); values only, no optimizer state. It renders
/// as before to rounding. Unsound Gaussians (recon4d/model/element_edits.h) are left out.
GaussianSet in_form(const GaussianSet& dynamic_set, SetForm form);

}  // namespace tessera
