// What: how far a splat reaches: its cut-off ellipse, its tile rectangle, the exact test per tile.
// Not: the loop that counts or writes instances: `for_each_tile` is the one function both use, so
// that a count can never differ from a fill.
// Source: [StopThePop] tile culling, [Faster-GS] opacity-aware bounds; method A.6, A.7.
#pragma once
#include "kernels/math/ewa.h"

namespace tessera {

inline constexpr int kTileSize = 16;  // pixels, both ways

/// α below this is not drawn  [3DGS].
template <class Real>
inline constexpr Real kMinAlpha = Real(1) / Real(255);

/// Half of the squared Mahalanobis radius at which o·G falls to 1/255: ln(255·o). Needs o ≥ 1/255.
template <class Real>
TESSERA_HD inline Real cutoff_power(Real opacity) {
  return log(Real(255) * opacity);
}

/// Tiles [x0, x1) × [y0, y1) of one view.
struct TileRect {
  int x0, y0, x1, y1;
  TESSERA_HD bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// What the tile test needs of a splat.
template <class Real>
struct Footprint {
  Vec2<Real> mean2d;  // pixels
  Sym2<Real> conic;   // pixels⁻²
  Real power;         // ½ dᵀ conic d ≤ power is drawn
};

/// First and last+1 tile along one axis; −0.5 because only pixel centres are sampled. Computed in
/// Real and clamped before the cast, so that a splat of any size is safe.
template <class Real>
TESSERA_HD inline void tile_interval(Real centre, Real half_extent, int tiles, int& first,
                                     int& last) {
  const Real reach = max_of(Real(0), half_extent - Real(0.5));
  const Real limit = Real(tiles) * Real(kTileSize);
  const Real low = floor(clamp_to(centre - reach, Real(0), limit));
  const Real high = ceil(clamp_to(centre + reach, Real(0), limit));
  first = int(low) / kTileSize;
  last = (int(high) + kTileSize - 1) / kTileSize;
}

/// The bounding box of the cut-off ellipse in tiles: half extents √(2·power·Σ2_ii).
template <class Real>
TESSERA_HD inline TileRect tile_rect(const ViewArgs<Real>& view, const Vec2<Real>& mean2d,
                                     const Sym2<Real>& cov2d, Real power) {
  TileRect rect{};
  if (!(power >= Real(0))) return rect;
  tile_interval(mean2d[0], Real(sqrt(Real(2) * power * cov2d.xx)), view.tiles_x, rect.x0, rect.x1);
  tile_interval(mean2d[1], Real(sqrt(Real(2) * power * cov2d.yy)), view.tiles_y, rect.y0, rect.y1);
  return rect;
}

/// Whether the splat's strongest response at a pixel centre region of the tile reaches the cut-off:
/// the exact minimum of ½ dᵀ conic d over the rectangle of the tile's pixel centres. One copy:
/// splats are counted with it in one stage and written with it in another.
template <class Real>
TESSERA_HD TESSERA_ONE_COPY inline bool touches_tile(const Footprint<Real>& splat, int tile_x,
                                                     int tile_y) {
  constexpr Real kSpan = Real(kTileSize - 1);
  const Real mx = splat.mean2d[0] - Real(0.5), my = splat.mean2d[1] - Real(0.5);
  const Real X0 = Real(tile_x * kTileSize), Y0 = Real(tile_y * kTileSize);
  const bool left = X0 - mx >= Real(0), right = mx > X0 + kSpan;
  const bool above = Y0 - my >= Real(0), below = my > Y0 + kSpan;
  if (!(left || right || above || below)) return true;
  // p: nearest corner, d: from p into the tile along each axis
  const Real px = right ? X0 + kSpan : X0, dx = right ? -kSpan : kSpan;
  const Real py = below ? Y0 + kSpan : Y0, dy = below ? -kSpan : kSpan;
  const Real ex = mx - px, ey = my - py;
  const Sym2<Real>& c = splat.conic;
  const auto fraction = [](Real numerator, Real denominator) {
    return clamp_to(numerator / denominator, Real(0), Real(1));
  };
  const Real tx = above || below ? fraction(c.xx * ex + c.xy * ey, dx * c.xx) : Real(0);
  const Real ty = left || right ? fraction(c.xy * ex + c.yy * ey, dy * c.yy) : Real(0);
  const Real qx = mx - (px + tx * dx);
  const Real qy = my - (py + ty * dy);
  return Real(0.5) * (c.xx * qx * qx + c.yy * qy * qy) + c.xy * qx * qy <= splat.power;
}

/// Calls visit(tile_y · tiles_x + tile_x) for each tile that the splat is drawn in, row by row.
template <class Real, class Visit>
TESSERA_HD inline void for_each_tile(const Footprint<Real>& splat, const TileRect& rect,
                                     int tiles_x, Visit&& visit) {
  for (int y = rect.y0; y < rect.y1; ++y)
    for (int x = rect.x0; x < rect.x1; ++x)
      if (touches_tile(splat, x, y)) visit(y * tiles_x + x);
}

}  // namespace tessera
