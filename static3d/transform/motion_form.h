// Conversion between the two forms of dynamic Gaussians, which describe the same family.
#pragma once
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// A dynamic set stored in `form` (kPair or kVelocity); values only, no optimizer state. It renders
/// as before to rounding. Unsound Gaussians (recon4d/model/element_edits.h) are left out.
GaussianSet in_form(const GaussianSet& dynamic_set, SetForm form);

/// The dynamic set in the form kVelocity, with the temporal filter in σ_t and the colours of each
/// Gaussian's own timestep: without levels of time.
GaussianSet plain_velocity_form(const GaussianModel& model);

}  // namespace tessera
