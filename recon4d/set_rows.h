// What: rows of one set added to another.
// Not: rows chosen or put in another order (hygiene.h, density.h, thinning.h).
#pragma once
#include "recon4d/gaussian_set.h"

namespace tessera {

/// Adds the values of `from` behind those of `to`, both in the host's memory and of one form;
/// where `to` has moments, the new ones are zero. Errors: std::logic_error: sets that store
/// differently.
void append_rows(GaussianSet& to, const GaussianSet& from);

}  // namespace tessera
