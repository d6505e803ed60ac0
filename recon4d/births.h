// What: dynamic Gaussians where what is left over static ones changes with time by more than noise.
// Not: growth by gradients (density.h), and no end of the static ones: when they are worth nothing
//       any more they are removed as others are.
// Source: docs/parsimony.md; residuals that change with time as a sign: [Ex4DGS].
#pragma once
#include "recon4d/worth.h"

namespace tessera {

/// Rows of the static set over which the residual changes with time beyond noise, and by more
/// squared error than `least`; at most `most`, those with the largest gain, ascending.
std::vector<int64_t> restless_rows(const Worth& worth, double least, int64_t most);

/// Their like as dynamic Gaussians in the form and layout of the dynamic set: in the same place, at
/// the moment when most is left over, as long as it is, coloured by it.
GaussianSet born_from(const GaussianModel& model, const Worth& worth,
                      const std::vector<int64_t>& rows);

}  // namespace tessera
