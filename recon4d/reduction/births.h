// What: static Gaussians become dynamic where what is left over them changes with time by more than
//       noise, and others are born beside them at the moment when most is left.
// Not: growth by gradients (density.h); the way back (stillness.h).
// Source: docs/parsimony.md; residuals that change with time as a sign: [Ex4DGS].
#pragma once
#include "recon4d/reduction/worth.h"

namespace tessera {

/// Rows of the static set over which the residual changes with time beyond noise, and by more
/// squared error than `least`; at most `most`, those with the largest gain, ascending.
std::vector<int64_t> restless_rows(const Worth& worth, double least, int64_t most);

/// They themselves as dynamic Gaussians in the form and layout of the dynamic set: at rest, and as
/// long as the clip, so that pictures hardly change.
GaussianSet moving_form(const GaussianModel& model, const Worth& worth,
                        const std::vector<int64_t>& rows);

/// Their like, at rest in the same place at the moment when most is left over, as long as it is,
/// coloured by it.
GaussianSet born_from(const GaussianModel& model, const Worth& worth,
                      const std::vector<int64_t>& rows);

}  // namespace tessera
