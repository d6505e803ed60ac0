// What: how a block of threads lies over a tile: a warp has an 8 × 4 part of it, a lane a pixel; the
// tile's splats pass through shared memory in chunks of one a thread.
// Not: what is done with a splat (blend.cu, blend_backward.cu).
// Source: sub-tiles of [Faster-GS]; method A.10, G.4.
#pragma once
#include "kernels/batch.h"

namespace tessera {

inline constexpr int kTileThreads = kTileSize * kTileSize;
inline constexpr int kPartWidth = 8, kPartHeight = 4;  // pixels of a warp
inline constexpr int kTileWarps = kTileThreads / 32;
inline constexpr int kBucket = 32;  // splats between two checkpoints

/// A tile of the batch and this thread's pixel in it.
struct BlockTile {
  const ViewArgs<float>* view;
  int part_x, part_y;  // first pixel of the warp's part
  int x, y;            // pixel
  bool inside;         // of the picture
  int64_t pixel;       // index within the view

  __device__ BlockTile(const ViewArgs<float>* views, int view_count, int64_t tile, int thread) {
    int b = 0;
    while (b + 1 < view_count && tile >= views[b + 1].first_tile) ++b;
    view = views + b;
    const int local = int(tile - view->first_tile);
    const int warp = thread / 32, lane = thread % 32;
    constexpr int kParts = kTileSize / kPartWidth;
    part_x = local % view->tiles_x * kTileSize + warp % kParts * kPartWidth;
    part_y = local / view->tiles_x * kTileSize + warp / kParts * kPartHeight;
    x = part_x + lane % kPartWidth, y = part_y + lane / kPartWidth;
    inside = x < view->width && y < view->height;
    pixel = int64_t(y) * view->width + x;
  }
  __device__ int64_t plane() const { return int64_t(view->width) * view->height; }
  /// Index of this pixel's channel c in a planar picture of the batch.
  __device__ int64_t colour_at(int c) const {
    return 3 * view->first_pixel + c * plane() + pixel;
  }
};

/// What blending reads of a splat, 48 bytes as three vectors.
struct alignas(16) SharedSplat {
  float4 a;  // mean2d, conic xx, xy
  float4 b;  // conic yy, opacity, colour r, g
  float4 c;  // colour b, power, view, negative

  __device__ Vec2<float> mean2d() const { return {a.x, a.y}; }
  __device__ Sym2<float> conic() const { return {a.z, a.w, b.x}; }
};
static_assert(sizeof(SharedSplat) == sizeof(Splat<float>));

/// Whether a splat may draw a pixel of the part that begins at (x, y). A little generous, as the
/// pixels decide for themselves.
__device__ inline bool meets_part(const SharedSplat& s, int x, int y) {
  const float least =
      least_power_in(s.mean2d(), s.conic(), float(x) + 0.5f, float(y) + 0.5f,
                     float(kPartWidth - 1), float(kPartHeight - 1));
  return least <= s.c.y * 1.0001f + 1e-3f;
}

/// Response of a splat at a pixel: offsets, conic · offset, falloff, α.
struct PixelResponse {
  float dx, dy, gx, gy, falloff, alpha;

  __device__ PixelResponse(const SharedSplat& s, int x, int y) {
    dx = s.a.x - (float(x) + 0.5f), dy = s.a.y - (float(y) + 0.5f);
    gx = s.a.z * dx + s.a.w * dy, gy = s.a.w * dx + s.b.x * dy;
    falloff = fast_exp(fminf(-0.5f * (dx * gx + dy * gy), 0.0f));  // splat_falloff
    alpha = s.b.y * falloff;
  }
};

}  // namespace tessera
