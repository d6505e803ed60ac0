// Promotion: static Gaussians become dynamic where the residual over them changes with time by more
// than noise, and further dynamic Gaussians are added beside them at the timestep of the largest
// residual. Source: docs/explanation/static-dynamic.md; residuals that change with time as a sign:
// [Ex4DGS].
#pragma once
#include "recon4d/reduction/contributions.h"

namespace tessera {

/// Elements of the static set over which the residual changes with time beyond noise, and by more
/// squared error over all frames than `least`, and, where masks say what moves, of whose light more
/// than a tenth lies in pixels that may; at most `most`, those with the largest gain, ascending.
std::vector<int64_t> time_varying_elements(const Contributions& contributions, double least,
                                           int64_t most);

/// They themselves as dynamic Gaussians in the form and layout of the dynamic set: at rest, and as
/// long as the clip, so that images hardly change.
GaussianSet as_dynamic(Backend& backend, const GaussianModel& model,
                       const Contributions& contributions, const std::vector<int64_t>& elements);

/// Their like, at rest in the same place at the timestep at which most is left over, as long as it
/// is, coloured by it.
GaussianSet spawn_dynamic(Backend& backend, const GaussianModel& model,
                          const Contributions& contributions, const std::vector<int64_t>& elements);

}  // namespace tessera
