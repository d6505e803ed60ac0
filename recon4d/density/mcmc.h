// MCMC densification on any backend: dead Gaussians become copies of alive ones, and copies are
// added up to growth_limit. The formula of copies is in kernels/math/relocation.h. Source: method
// B, 0.28  [3DGS-MCMC].
#pragma once
#include <array>

#include "recon4d/density/density.h"
#include "recon4d/model/train_state.h"

namespace tessera {

/// How many each set of `total` new Gaussians gets, in proportion to its weight; none where no
/// weight is.
std::array<int64_t, 2> shares_of(int64_t total, const std::array<int64_t, 2>& weights);

/// Gaussians of both sets after a density control: min(limit, ⌊growth·count⌋), never fewer.
int64_t grown_count(int64_t count, double growth, int64_t limit);

/// Relocates within each set, then adds to both: what is added is divided by the opacity that lived
/// in them. Sources lose their moments, what is added has none, what was dead keeps its own as the
/// sources of the method do.
/// Errors: NumericalError: no Gaussian is alive, so nothing would be drawn again.
std::array<DensityReport, 2> control_mcmc(Backend& backend, const TrainOptions& options,
                                          TrainState& state);

}  // namespace tessera
