// What: the tiles of a warp's splats, small ones by their own lane, large ones by the whole warp.
// Not: the tile test (math/bounds.h). Counting and writing instances both walk through here, so
// that one can never differ from the other.
// Source: method A.8.
#pragma once
#include <type_traits>

#include "kernels/math/bounds.h"

namespace tessera {

/// Splats with more candidate tiles than this are shared by the warp.
inline constexpr int kOwnTiles = 8;

/// All lanes of a warp call this together; a lane without a splat passes an empty rect.
/// Small splats: visit(tile) for each tile, by the lane itself. Large ones: 32 candidates at a
/// time, either shared(owner, hit, tile, place) by all lanes together, `place` counted from the
/// owner's first tile, or shared(count) by the owner at the end.
template <class Visit, class Shared>
__device__ inline void walk_tiles(const BoundsOptions& options, bool balanced,
                                  const Footprint<float>& splat, const TileRect& rect, int tiles_x,
                                  Visit&& visit, Shared&& shared) {
  const int area = rect.empty() ? 0 : rect.area();
  const bool large = balanced && area > kOwnTiles;
  if (!large) for_each_tile(options, splat, rect, tiles_x, visit);
  const unsigned lane = threadIdx.x % 32;
  for (unsigned owners = __ballot_sync(~0u, large); owners != 0; owners &= owners - 1) {
    const int owner = __ffs(int(owners)) - 1;
    const auto from = [owner](auto value) { return __shfl_sync(~0u, value, owner); };
    const Footprint<float> theirs{
        {from(splat.mean2d[0]), from(splat.mean2d[1])},
        {from(splat.conic.xx), from(splat.conic.xy), from(splat.conic.yy)},
        from(splat.power)};
    const int x0 = from(int(rect.x0)), y0 = from(int(rect.y0)), x1 = from(int(rect.x1));
    const int candidates = from(area), width = x1 - x0, row = from(tiles_x);
    int total = 0;
    for (int begin = 0; begin < candidates; begin += 32) {
      const int i = begin + int(lane);
      const int x = x0 + i % width, y = y0 + i / width;
      const bool hit = i < candidates && (!options.tile_culling || touches_tile(theirs, x, y));
      const unsigned hits = __ballot_sync(~0u, hit);
      if constexpr (std::is_invocable_v<Shared, int, bool, int, int>)
        shared(owner, hit, y * row + x, total + __popc(hits & ((1u << lane) - 1)));
      total += __popc(hits);
    }
    if constexpr (std::is_invocable_v<Shared, int>) {
      if (int(lane) == owner) shared(total);
    }
  }
}

}  // namespace tessera
