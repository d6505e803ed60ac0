// What: the tiles of a warp's splats, small ones by their own lane, large ones by the whole warp.
// Not: which tiles a splat has (math/bounds.h).
// Source: method A.8.
#pragma once
#include "kernels/math/bounds.h"

namespace tessera {

/// Splats with more tiles than this are shared by the warp.
inline constexpr int kOwnTiles = 8;

/// All lanes of a warp call this together; a lane without a splat passes an empty rect.
/// Small splats: visit(tile) for each tile, by the lane itself. Large ones: 32 tiles at a time,
/// shared(owner, listed, tile, place) by all lanes together, `place` counted from the owner's first
/// tile; lanes behind its last one are not `listed`.
template <class Visit, class Shared>
__device__ inline void walk_tiles(bool balanced, const TileRect& rect, int tiles_x, Visit&& visit,
                                  Shared&& shared) {
  const int area = rect.empty() ? 0 : rect.area();
  const bool large = balanced && area > kOwnTiles;
  if (!large) for_each_tile(rect, tiles_x, visit);
  const int lane = int(threadIdx.x % 32);
  for (unsigned owners = __ballot_sync(~0u, large); owners != 0; owners &= owners - 1) {
    const int owner = __ffs(int(owners)) - 1;
    const auto from = [owner](int value) { return __shfl_sync(~0u, value, owner); };
    const int x0 = from(rect.x0), y0 = from(rect.y0), width = from(rect.x1) - x0;
    const int tiles = from(area), row = from(tiles_x);
    for (int begin = 0; begin < tiles; begin += 32) {
      const int place = begin + lane;
      shared(owner, place < tiles, (y0 + place / width) * row + x0 + place % width, place);
    }
  }
}

}  // namespace tessera
