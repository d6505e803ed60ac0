// What: what flows between the stages for a batch of B views: Splats, TileInstances, Images, Loss.
// Not: parameters (gaussians.h). Index names: n Gaussian, b view, s splat, t tile, i instance.
#pragma once
#include <vector>

#include "kernels/base/buffer.h"
#include "kernels/base/camera.h"
#include "kernels/math/blending.h"
#include "kernels/math/spherical_harmonics.h"

namespace tessera {

/// The views of a batch in kernel form; tiles and pixels of all views are numbered through.
template <class Real>
struct ViewBatch {
  std::vector<ViewArgs<Real>> views;  // [B]
  int64_t tiles = 0;                  // over all views
  int64_t pixels = 0;
};

template <class Real>
ViewBatch<Real> make_view_batch(const std::vector<View>& views);

struct RenderOptions {
  int sh_degree = kMaxShDegree;      // bands evaluated, of those that are stored
  double background[3] = {0, 0, 0};  // linear blend target, [0, 1] RGB
  double near_plane = 0.2;           // world units along the viewing axis
  double far_plane = 1e4;
};

/// Visible (Gaussian, view) pairs. Those of one Gaussian are neighbours, in the order of views.
template <class Real>
struct Splats {
  int64_t count = 0;          // S
  Buffer<int32_t> gaussian;   // [S] static set first, then dynamic
  Buffer<int32_t> view;       // [S]
  Buffer<Real> depth;         // [S] world units
  Buffer<Vec2<Real>> mean2d;  // [S] pixels
  Buffer<Sym2<Real>> conic;   // [S] pixels⁻²
  Buffer<Real> opacity;       // [S] effective: σ(logit)·p(t)
  Buffer<Vec3<Real>> colour;  // [S] clamped at 0
  Buffer<uint8_t> negative;   // [S] bit c: channel c was clamped
  Buffer<TileRect> rect;      // [S]
  Buffer<int32_t> tiles;      // [S] tiles touched, ≥ 1
  Buffer<int64_t> first_of;   // [N+1] first splat of each Gaussian
  int64_t invalid = 0;        // Gaussians culled for a zero quaternion or non-finite values
};

/// (tile, splat) pairs, by tile, front to back inside a tile.
template <class Real>
struct TileInstances {
  int64_t count = 0;            // I
  Buffer<int32_t> splat;        // [I]
  Buffer<int64_t> tile_begin;   // [tiles+1]
  Buffer<int64_t> first_of;     // [S+1] first entry of each splat in `slot`
  Buffer<int64_t> slot;         // [I] places of a splat's instances; filled when asked
  Buffer<int32_t> depth_order;  // [S] splats front to back
};

/// Rendered views, planar: channel c of view b starts at 3·first_pixel + c·width·height.
template <class Real>
struct Images {
  Buffer<Real> colour;         // [3·pixels] background included, not clamped
  Buffer<Real> transmittance;  // [pixels] light of the background that remains
  Buffer<int32_t> used;        // [pixels] 1 + place in the tile's list of the last blended splat
};

struct LossWeights {
  double l1 = 0.8;     // weight of mean |I − G|
  double dssim = 0.2;  // weight of 1 − SSIM
};

/// Loss of one view, un-divided by B.
struct ViewLoss {
  double l1 = 0, ssim = 0, total = 0;
};

}  // namespace tessera
