// The reach of a splat: its cut-off ellipse, its tile rectangle, and its response in a rectangle.
// Single tiles are not tested, because an instance in which a splat draws nothing costs less than
// the test (docs/development/performance.md). Source: [Faster-GS] opacity-aware bounds;
// [StopThePop] least_power_in; method A.6, A.7, C.3.
#pragma once
#include "kernels/math/ewa.h"

namespace tessera {

inline constexpr int kTileSize = 16;  // pixels, both ways

/// √(2 ln 255): where an opaque splat falls to 1/255, in standard deviations  [3DGS].
inline constexpr double kTruncationSigma = 3.3290429691304455;

/// Half of the squared Mahalanobis radius at which o·G falls to 1/`inverse`. Needs o ≥ 1/inverse.
template <class Real>
TESSERA_HD inline Real cutoff_power(Real opacity, Real inverse = Real(255)) {
  return log(inverse * opacity);
}

/// Where a splat ends. Either α = o·G below a threshold is not drawn; or G below it is not,
/// whatever the opacity: then a splat of opacity 0 draws nothing but still has a gradient. Both are
/// the same two comparisons, so that no loop over pixels has a branch.  [method C.3]
template <class Real>
struct Cutoff {
  Real least_alpha = Real(1) / Real(255);  // exp(−k²/2); 0 by falloff
  Real least_falloff = Real(0);            // 0; exp(−k²/2) by falloff
  Real inverse = Real(255);                // exp(k²/2)

  /// Whether a splat of that opacity is drawn anywhere; false for NaN.
  TESSERA_HD bool keeps(Real opacity) const { return opacity >= least_alpha; }
  /// Whether it is drawn in a pixel where it has that α and G.
  TESSERA_HD bool draws(Real alpha, Real falloff) const {
    return alpha >= least_alpha && falloff >= least_falloff;
  }
  /// The same where it is known which of the two comparisons decides.
  template <bool ByFalloff>
  TESSERA_HD bool draws(Real alpha, Real falloff) const {
    return ByFalloff ? falloff >= least_falloff : alpha >= least_alpha;
  }
  TESSERA_HD bool by_falloff() const { return least_falloff > Real(0); }
  /// Half of the squared Mahalanobis radius at which it ends.
  TESSERA_HD Real power(Real opacity) const {
    return cutoff_power(by_falloff() ? Real(1) : opacity, inverse);
  }
};

/// The cut-off at `sigma` standard deviations of an opaque splat (with `by_falloff`: of any). An
/// inverse that is a whole number to rounding is that number: 255 for kTruncationSigma.
template <class Real>
Cutoff<Real> make_cutoff(double sigma, bool by_falloff) {
  constexpr double kRounding = 1e-12;
  double inverse = std::exp(0.5 * sigma * sigma);
  const double whole = std::round(inverse);
  if (std::abs(inverse - whole) < kRounding * inverse) inverse = whole;
  const Real threshold = Real(1) / Real(inverse);
  return {by_falloff ? Real(0) : threshold, by_falloff ? threshold : Real(0), Real(inverse)};
}

/// How tightly a splat's tiles are found. No choice changes an image: pixels are cut off by
/// themselves. Looser bounds only list splats in tiles where they draw nothing.
struct BoundsOptions {
  bool rectangular = true;    // else a square of the longer half extent  [3DGS]
  bool opacity_aware = true;  // else every splat reaches as far as an opaque one
};

/// Tiles [x0, x1) × [y0, y1) of one view.
struct TileRect {
  uint16_t x0, y0, x1, y1;
  TESSERA_HD bool empty() const { return x0 >= x1 || y0 >= y1; }
  /// Fits: make_view_batch refuses views with more tiles.
  TESSERA_HD int area() const { return (x1 - x0) * (y1 - y0); }
};

/// First and last+1 tile along one axis; −0.5 because only pixel centres are sampled. Computed in
/// Real and clamped before the cast, so that a splat of any size is safe.
template <class Real>
TESSERA_HD inline void tile_interval(Real centre, Real half_extent, int tiles, uint16_t& first,
                                     uint16_t& last) {
  const Real reach = max_of(Real(0), half_extent - Real(0.5));
  const Real limit = Real(tiles) * Real(kTileSize);
  const Real low = floor(clamp_to(centre - reach, Real(0), limit));
  const Real high = ceil(clamp_to(centre + reach, Real(0), limit));
  first = uint16_t(int(low) / kTileSize);
  last = uint16_t((int(high) + kTileSize - 1) / kTileSize);
}

/// Power of the cut-off ellipse that bounds are made for.
template <class Real>
TESSERA_HD inline Real bounds_power(const BoundsOptions& options, Real opacity,
                                    const Cutoff<Real>& cutoff = {}) {
  return cutoff.power(options.opacity_aware ? opacity : Real(1));
}

/// The bounding box of the cut-off ellipse in tiles: half extents √(2·power·Σ2_ii).
template <class Real>
TESSERA_HD inline TileRect tile_rect(const BoundsOptions& options, const ViewArgs<Real>& view,
                                     const Vec2<Real>& mean2d, const Sym2<Real>& cov2d,
                                     Real power) {
  TileRect rect{};
  if (!(power >= Real(0))) return rect;
  Real xx = cov2d.xx, yy = cov2d.yy;
  if (!options.rectangular) {  // both as long as the longer axis of the ellipse: its eigenvalue
    const Real middle = Real(0.5) * (xx + yy), half = Real(0.5) * (xx - yy);
    xx = yy = middle + sqrt(half * half + cov2d.xy * cov2d.xy);
  }
  tile_interval(mean2d[0], Real(sqrt(Real(2) * power * xx)), view.tiles_x, rect.x0, rect.x1);
  tile_interval(mean2d[1], Real(sqrt(Real(2) * power * yy)), view.tiles_y, rect.y0, rect.y1);
  return rect;
}

/// Least of ½ dᵀ conic d over the rectangle [x0, x0 + span_x] × [y0, y0 + span_y], d = mean −
/// point: how strongly the splat can respond there. Needs no branch but inside/outside.
template <class Real>
TESSERA_HD inline Real least_power_in(const Vec2<Real>& mean2d, const Sym2<Real>& c, Real x0,
                                      Real y0, Real span_x, Real span_y) {
  const Real mx = mean2d[0], my = mean2d[1];
  const bool left = x0 - mx >= Real(0), right = mx > x0 + span_x;
  const bool above = y0 - my >= Real(0), below = my > y0 + span_y;
  if (!(left || right || above || below)) return Real(0);
  // p: nearest corner, d: from p into the rectangle along each axis
  const Real px = right ? x0 + span_x : x0, dx = right ? -span_x : span_x;
  const Real py = below ? y0 + span_y : y0, dy = below ? -span_y : span_y;
  const Real ex = mx - px, ey = my - py;
  const auto fraction = [](Real numerator, Real denominator) {
    return clamp_to(fast_divide(numerator, denominator), Real(0), Real(1));
  };
  const Real tx = above || below ? fraction(c.xx * ex + c.xy * ey, dx * c.xx) : Real(0);
  const Real ty = left || right ? fraction(c.xy * ex + c.yy * ey, dy * c.yy) : Real(0);
  const Real qx = mx - (px + tx * dx);
  const Real qy = my - (py + ty * dy);
  return Real(0.5) * (c.xx * qx * qx + c.yy * qy * qy) + c.xy * qx * qy;
}

/// Calls visit(tile_y · tiles_x + tile_x) for each tile of a splat, row by row.
template <class Visit>
TESSERA_HD inline void for_each_tile(const TileRect& rect, int tiles_x, Visit&& visit) {
  for (int y = rect.y0; y < rect.y1; ++y)
    for (int x = rect.x0; x < rect.x1; ++x) visit(y * tiles_x + x);
}

}  // namespace tessera
