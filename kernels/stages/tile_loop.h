// Loops that blending and its backward pass share on the CPU: the pixels of a tile as rows of
// lanes, and the rows of a splat. Lanes are an array of fixed length, so that the compiler uses
// vectors.
#pragma once
#include <cstdint>

#include "kernels/base/parallel.h"
#include "kernels/batch.h"

namespace tessera {

/// values[index[i + Ahead]], when that is before `end`.
template <int Ahead, class Values, class Index>
inline void prefetch(const Values& values, const Index& index, int64_t i, int64_t end) {
  if (i + Ahead >= end) return;
  const auto* const element = &values[index[i + Ahead]];
  __builtin_prefetch(element);
  __builtin_prefetch(reinterpret_cast<const char*>(element + 1) - 1);  // may lie in two lines
}

/// A tile of a view: where its pixels are.
template <class Real>
struct Tile {
  const ViewArgs<Real>* view;
  int x0, y0;          // first pixel
  int width, height;   // pixels inside the image, ≤ kTileSize
  int64_t begin, end;  // its instances

  /// Index of the pixel at the start of a row, within the view.
  int64_t row_start(int y) const { return int64_t(y0 + y) * view->width + x0; }
  int64_t view_pixels() const { return int64_t(view->width) * view->height; }
};

/// Calls body(tile) for every tile of every view, in parallel.
template <class Real, class Body>
void for_each_tile_of(const ViewBatch<Real>& batch, const TileInstances<Real>& instances,
                      Body&& body) {
  constexpr int64_t kGrain = 4;  // tiles per task
  std::vector<int32_t> view_of(static_cast<size_t>(batch.tiles));
  for (size_t b = 0; b < batch.views.size(); ++b) {
    const ViewArgs<Real>& v = batch.views[b];
    for (int64_t t = 0; t < int64_t(v.tiles_x) * v.tiles_y; ++t)
      view_of[size_t(v.first_tile + t)] = int32_t(b);
  }
  parallel_for(batch.tiles, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t t = begin; t < end; ++t) {
      const ViewArgs<Real>& v = batch.views[size_t(view_of[size_t(t)])];
      const int local = int(t - v.first_tile);
      Tile<Real> tile{&v, local % v.tiles_x * kTileSize, local / v.tiles_x * kTileSize, 0,
                      0,  instances.tile_begin[t],       instances.tile_begin[t + 1]};
      tile.width = min_of(kTileSize, v.width - tile.x0);
      tile.height = min_of(kTileSize, v.height - tile.y0);
      body(tile);
    }
  });
}

/// Prefetches the record of a splat that comes soon after instance i of the tile.
template <class Real>
void prefetch_splat(const Splats<Real>& splats, const TileInstances<Real>& instances,
                    const Tile<Real>& tile, int64_t i) {
  prefetch<4>(splats.splat, instances.splat, i, tile.end);
}

/// One splat as the lanes of a tile see it, with the rows that its cut-off ellipse reaches.
template <class Real>
struct TileSplat {
  Sym2<Real> conic;
  Real dx0, dy0;  // mean2d − centre of the tile's first pixel
  Real opacity;
  Vec3<Real> colour;
  int first_row, last_row;  // [first, last)

  TileSplat(const Splats<Real>& splats, int32_t s, const Tile<Real>& tile)
      : TileSplat(splats.splat[s], tile) {}
  TileSplat(const Splat<Real>& splat, const Tile<Real>& tile)
      : conic(splat.conic),
        dx0(splat.mean2d[0] - Real(tile.x0) - Real(0.5)),
        dy0(splat.mean2d[1] - Real(tile.y0) - Real(0.5)),
        opacity(splat.opacity),
        colour(splat.colour) {
    // half height of ½ dᵀ conic d ≤ power: √(2·power·conic_xx / det), one row to spare
    const Real det = conic.xx * conic.yy - conic.xy * conic.xy;
    const Real reach = sqrt(Real(2) * splat.power * conic.xx / det) + Real(1);
    const Real rows = Real(tile.height);
    first_row = reach == reach ? int(clamp_to(dy0 - reach, Real(0), rows)) : 0;
    last_row = reach == reach ? int(clamp_to(dy0 + reach + Real(1), Real(0), rows)) : tile.height;
  }
};

}  // namespace tessera
