// Data that flows between the stages for a batch of B views: Splats, TileInstances, Images, Loss.
// Index names are n for Gaussian, b for view, s for splat, t for tile and i for instance.
#pragma once
#include <vector>

#include "kernels/base/buffer.h"
#include "kernels/base/camera.h"
#include "kernels/drawing_rules.h"
#include "kernels/math/blending.h"
#include "kernels/math/photometric.h"
#include "kernels/math/spherindrical.h"
#include "kernels/math/splat.h"

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

/// How the gradient of blending is traversed on a device; the CPU has one way.
enum class BackwardForm {
  kSubTile,  // lanes are pixels of an 8 × 4 part of a tile, splats that miss it are skipped
  kPixel,    // lanes are pixels, every splat of the tile is visited  [3DGS]
};

/// Techniques of [Faster-GS] that can be taken out one by one, to measure what each contributes.
/// The bounds change what is drawn where on any backend; the others only how a device does it.
struct KernelSwitches {
  BoundsOptions bounds;
  bool balanced_instances = true;  // large splats are written by whole warps
  bool separate_sort = true;       // depth once, then tiles; else one sort of (tile, depth)
  bool warp_culling = true;        // a warp skips splats that miss its part of the tile
  BackwardForm backward = BackwardForm::kSubTile;
  bool deterministic = false;  // gradients are added in a fixed order
};

struct RenderOptions : DrawingRules {
  double background[3] = {0, 0, 0};  // linear blend target, [0, 1] RGB
  KernelSwitches kernels;
};

template <class Real>
SplatRules<Real> make_splat_rules(const RenderOptions& options);
/// Of a set that stores `coefficients` in each of `time_levels` beside the first.
template <class Real>
ColourRules<Real> make_colour_rules(const RenderOptions& options, int coefficients,
                                    int time_levels);

/// `negative` of a splat that is listed but not drawn, because its colour is not finite.
inline constexpr uint32_t kNotDrawn = ~0u;

/// A splat as blending gathers it, twelve words in one aligned record.
template <class Real>
struct alignas(16) Splat {
  Vec2<Real> mean2d;  // pixels
  Sym2<Real> conic;   // pixels⁻²
  Real opacity;       // effective: σ(logit)·p(t)
  Vec3<Real> colour;  // clamped at 0
  Real power;         // of the cut-off ellipse
  int32_t view;
  uint32_t negative;  // bit c: channel c was clamped
};

/// Visible (Gaussian, view) pairs. Those of one Gaussian are neighbours, in the order of views.
template <class Real>
struct Splats {
  explicit Splats(Memory& memory = host_memory())
      : splat(memory),
        depth(memory),
        rect(memory),
        tiles(memory),
        gaussian(memory),
        slope(memory),
        time_slope(memory),
        first_of(memory) {}

  int64_t count = 0;          // S
  Buffer<Splat<Real>> splat;  // [S]
  Buffer<Real> depth;         // [S] world units
  Buffer<TileRect> rect;      // [S]
  Buffer<int32_t> tiles;      // [S] tiles of `rect`; a splat with none is as good as invisible
  Buffer<int32_t> gaussian;   // [S] static set first, then dynamic; a device's, else empty
  /// [S] where a device's pass was for its gradient, else empty.
  Buffer<ColourSlope<Real>> slope;
  /// [S] ∂(un-clamped colour)/∂(mean time) beside it where colours have levels of time.
  Buffer<Vec3<Real>> time_slope;
  Buffer<int64_t> first_of;  // [N+1] first splat of each Gaussian
  int64_t instances = 0;     // Σ tiles
  int64_t invalid = 0;       // Gaussians culled for a zero quaternion or non-finite values
};

/// (tile, splat) pairs, by tile, front to back inside a tile.
template <class Real>
struct TileInstances {
  explicit TileInstances(Memory& memory = host_memory())
      : splat(memory),
        tile_begin(memory),
        first_of(memory),
        slot(memory),
        depth_order(memory),
        tile_order(memory) {}

  int64_t count = 0;            // I
  Buffer<int32_t> splat;        // [I]
  Buffer<int64_t> tile_begin;   // [tiles+1]
  Buffer<int64_t> first_of;     // [S] first entry of each splat in `slot`; it has tiles[s] of them
  Buffer<int64_t> slot;         // [I] places of a splat's instances; filled on request
  Buffer<int32_t> depth_order;  // [S] splats front to back
  Buffer<int32_t> tile_order;   // [tiles] a device's: long lists first, so that none comes last
};

/// Rendered views, planar: channel c of view b starts at 3·first_pixel + c·width·height.
template <class Real>
struct Images {
  explicit Images(Memory& memory = host_memory())
      : colour(memory), transmittance(memory), used(memory) {}

  Buffer<Real> colour;         // [3·pixels] background included, not clamped
  Buffer<Real> transmittance;  // [pixels] transmittance: share of the background that remains
  Buffer<int32_t> used;        // [pixels] 1 + place in the tile's list of the last blended splat
};

}  // namespace tessera
