// What: the order of a set in which neighbours in space (and time) are neighbours in memory.
// Not: the move itself (density.h: reorder).
// Source: method A.14, D.7.
#pragma once
#include <cstdint>
#include <vector>

#include "recon4d/gaussian_set.h"

namespace tessera {

/// order[i] = Gaussian that comes i-th: by the Morton code of its mean (21 bits an axis over the
/// largest side of the bounding box, x lowest); a dynamic set then stably by 32 bins of mean_time.
std::vector<int64_t> locality_order(const GaussianSet& set);

}  // namespace tessera
