// What: rows of one set added to another; rows that are not among some.
// Not: rows chosen or put in another order (validity.h, density.h, pruning.h).
#pragma once
#include <vector>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Adds the values of `from` behind those of `to`, both in the host's memory and of one form;
/// where `to` has moments, the new ones are zero. Errors: std::logic_error: sets that store
/// differently.
void append_rows(GaussianSet& to, const GaussianSet& from);

/// Of `count` rows those that are not among `rows`, which ascend; ascending.
std::vector<int64_t> rows_but(int64_t count, const std::vector<int64_t>& rows);

}  // namespace tessera
