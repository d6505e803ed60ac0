// Footprints of random splats and the pixels that they cover in a tile, by brute force over pixel
// centres.
#pragma once
#include "kernels/math/bounds.h"
#include "tests/support/random.h"

namespace tessera::testing {

/// Where a splat is drawn: ½ dᵀ conic d ≤ power.
template <class Real>
struct Footprint {
  Vec2<Real> mean2d;  // pixels
  Sym2<Real> conic;   // pixels⁻²
  Real power;
};

struct FootprintCase {
  Footprint<double> footprint;
  Sym2<double> cov2d;
  double opacity;
};

/// Axes between 1 and 12 pixels, or a needle; `on_pixel_centre`: the mean on a line of a tile's
/// first or last pixel centres.
inline FootprintCase random_footprint(Random& random, bool on_pixel_centre, bool needle = false) {
  const double angle = random.uniform(0, M_PI), c = std::cos(angle), s = std::sin(angle);
  const double a = std::exp(needle ? random.uniform(6, 12) : random.uniform(0, 5));
  const double b = needle ? 0.3 : std::exp(random.uniform(0, 5));
  FootprintCase out;
  out.cov2d = {a * c * c + b * s * s, (a - b) * c * s, a * s * s + b * c * c};
  const double det = out.cov2d.xx * out.cov2d.yy - out.cov2d.xy * out.cov2d.xy;
  out.footprint.conic = {out.cov2d.yy / det, -out.cov2d.xy / det, out.cov2d.xx / det};
  out.footprint.mean2d = {random.uniform(-10, 60), random.uniform(-10, 60)};
  if (on_pixel_centre)
    out.footprint.mean2d[random.below(2)] =
        kTileSize * random.below(4) + (random.below(2) ? 0.5 : 15.5);
  out.opacity = random.uniform(0.005, 1);
  out.footprint.power = cutoff_power(out.opacity);
  return out;
}

/// min ½ dᵀ conic d over the 256 pixel centres of a tile.
inline double least_over_centres(const Footprint<double>& f, int tile_x, int tile_y) {
  double least = INFINITY;
  for (int y = 0; y < kTileSize; ++y)
    for (int x = 0; x < kTileSize; ++x) {
      const double dx = tile_x * kTileSize + x + 0.5 - f.mean2d[0];
      const double dy = tile_y * kTileSize + y + 0.5 - f.mean2d[1];
      least = std::min(least,
                       0.5 * (f.conic.xx * dx * dx + f.conic.yy * dy * dy) + f.conic.xy * dx * dy);
    }
  return least;
}

}  // namespace tessera::testing
