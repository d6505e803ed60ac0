// Sums over the pixels of every splat on the CPU, front to back through each tile. The gradient of
// blending and the sensitivity share this traversal; the type Walk defines the summands. Each
// instance writes its own sum, and a second pass adds those of a splat in order, so the result does
// not depend on the number of threads.
#pragma once
#include "kernels/backend.h"
#include "kernels/stages/tile_loop.h"

namespace tessera {

/// A value for each pixel of a tile.
template <class Real>
using TileValues = Real[kTileSize][kTileSize];

/// What every walk keeps of a tile's pixels.
template <class Real>
struct WalkState {
  TileValues<Real> transmittance = {};
  TileValues<int32_t> used = {};
  int32_t last = 0;  // most of `used`
};

/// Calls load(x, y, i) for the pixels of the tile that lie in the image; i: of channel 0 in
/// planar images, those of the next ones are `pixels` of the view further on.
template <class Real, class Load>
void load_pixels(const BlendBackwardArgs<Real>& args, const Tile<Real>& tile,
                 WalkState<Real>& state, Load&& load) {
  const int64_t first = tile.view->first_pixel;
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x) {
      const int64_t p = tile.row_start(y) + x;
      load(x, y, 3 * first + p);
      state.transmittance[y][x] = Real(1);
      state.used[y][x] = args.images->used[first + p];
      state.last = max_of(state.last, state.used[y][x]);
    }
}

/// Calls give(splat, sum) for every splat. Walk<Real> has
///   Sum, kTerms: what is given, of that many scalars, with +=; Sum{} is zero
///   load(asked, tile): the state of the tile's pixels in front of all splats
///   row<ByFalloff>(splat, cutoff, y, index, sum): a row's step past the tile's splat `index`, its
///     share added to sum[kTerms][kTileSize]
///   reduced(splat, sum): a Sum of the terms over the lanes.
/// `of_instances` is scratch that only grows.
template <class Walk, class Args, class Real, class Give>
void sum_over_splats(const Args& asked, const BlendBackwardArgs<Real>& args,
                     Buffer<typename Walk::Sum>& of_instances, Give&& give) {
  using Sum = typename Walk::Sum;
  const TileInstances<Real>& instances = *args.forward.instances;
  const Splats<Real>& splats = *args.forward.splats;
  const Cutoff<Real> cutoff = make_cutoff<Real>(args.forward.options);
  of_instances.resize(instances.count);
  for_each_tile_of(*args.forward.batch, instances, [&](const Tile<Real>& tile) {
    Walk walk;
    walk.load(asked, tile);
    for (int64_t i = tile.begin; i < tile.end; ++i) {
      const int32_t index = int32_t(i - tile.begin);
      if (index >= walk.last) {
        of_instances[i] = {};
        continue;
      }
      prefetch_splat(splats, instances, tile, i);
      Real lanes[Walk::kTerms][kTileSize] = {};
      const TileSplat<Real> splat(splats, instances.splat[i], tile);
      for (int y = splat.first_row; y < splat.last_row; ++y)
        cutoff.by_falloff() ? walk.template row<true>(splat, cutoff, y, index, lanes)
                            : walk.template row<false>(splat, cutoff, y, index, lanes);
      of_instances[i] = Walk::reduced(splat, lanes);
    }
  });
  constexpr int64_t kGrain = 1024;  // splats per task
  const Buffer<Sum>& sums = of_instances;
  parallel_for(splats.count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t s = begin; s < end; ++s) {
      Sum sum{};
      const int64_t first = instances.first_of[s], last = first + splats.tiles[s];
      for (int64_t k = first; k < last; ++k) {
        prefetch<16>(sums, instances.slot, k, instances.count);
        sum += sums[instances.slot[k]];
      }
      give(s, sum);
    }
  });
}

}  // namespace tessera
