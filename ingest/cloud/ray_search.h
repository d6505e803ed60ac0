// The search along the ray of a pixel (kernels/math/ray_search.h) on the CPU: planes by grey
// patches at whole pixels, in vectors; then between planes by patches in colour.
#pragma once
#include <vector>

#include "kernels/math/ray_search.h"

namespace tessera {

/// `views`: with images in the host's memory; the query's has another one that it is compared with
/// at least.
RayDepth ray_depth(const std::vector<SearchView>& views, const DepthRange& range,
                   const RayQuery& query);

}  // namespace tessera
