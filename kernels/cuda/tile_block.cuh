// What: how a block of threads lies over a tile: a warp has an 8 × 8 part of it, a lane two pixels.
// Warps go through the tile's splats on their own, 32 at a time: no warp waits for another.
// Not: what is done with a splat (blend.cu, blend_backward.cu).
// Source: sub-tiles of [Faster-GS]; method A.10, G.4.
#pragma once
#include "kernels/batch.h"

namespace tessera {

inline constexpr int kTilePixels = kTileSize * kTileSize;
inline constexpr int kPart = 8;         // pixels of a warp, both ways
inline constexpr int kLanePixels = 2;   // one above the other, half a part apart
inline constexpr int kTileThreads = kTilePixels / kLanePixels;
inline constexpr int kTileWarps = kTileThreads / 32;
inline constexpr int kBucket = 32;      // splats between two checkpoints

/// A tile of the batch.
struct BatchTile {
  const ViewArgs<float>* view;
  int x0, y0;  // first pixel

  __device__ BatchTile(const ViewArgs<float>* views, int view_count, int64_t tile) {
    int b = 0;
    while (b + 1 < view_count && tile >= views[b + 1].first_tile) ++b;
    view = views + b;
    const int local = int(tile - view->first_tile);
    x0 = local % view->tiles_x * kTileSize, y0 = local / view->tiles_x * kTileSize;
  }
  /// First pixel of a warp's part.
  __device__ int part_x(int warp) const { return x0 + warp % (kTileSize / kPart) * kPart; }
  __device__ int part_y(int warp) const { return y0 + warp / (kTileSize / kPart) * kPart; }
};

/// Pixel number i of a tile's 256: by warp, then upper and lower half of its part, then lane.
struct TilePixel {
  int x, y;
  bool inside;    // of the picture
  int64_t index;  // within the batch's one-channel pictures
  int64_t first_colour, plane;

  __device__ TilePixel(const BatchTile& tile, int i) {
    const int warp = i / (32 * kLanePixels), lane = i % 32, half = i / 32 % kLanePixels;
    x = tile.part_x(warp) + lane % kPart;
    y = tile.part_y(warp) + half * (kPart / kLanePixels) + lane / kPart;
    const ViewArgs<float>& view = *tile.view;
    inside = x < view.width && y < view.height;
    plane = int64_t(view.width) * view.height;
    const int64_t within = int64_t(y) * view.width + x;
    index = view.first_pixel + within;
    first_colour = 3 * view.first_pixel + within;
  }
  /// Index of channel c in a planar picture of the batch.
  __device__ int64_t colour_at(int c) const { return first_colour + c * plane; }
};
/// Number of a thread's pixel p in its tile.
__device__ inline int pixel_of_thread(int p) {
  return int(threadIdx.x) / 32 * (32 * kLanePixels) + p * 32 + int(threadIdx.x) % 32;
}

/// exp(−½ x) = 2^(kExponent·x).
inline constexpr float kExponent = -0.5f * 1.44269504088896341f;

/// What blending reads of a splat, 48 bytes as three vectors, its conic times kExponent.
struct alignas(16) SharedSplat {
  float4 a;  // mean2d, conic xx, xy
  float4 b;  // conic yy, opacity, colour r, g
  float4 c;  // colour b, power, view, negative

  __device__ static SharedSplat load(const Splat<float>* splat) {
    const float4* from = reinterpret_cast<const float4*>(splat);
    SharedSplat s{from[0], from[1], from[2]};
    s.a.z *= kExponent, s.a.w *= kExponent, s.b.x *= kExponent;
    return s;
  }
};
static_assert(sizeof(SharedSplat) == sizeof(Splat<float>));

/// Whether a splat may draw a pixel of the part that begins at (x, y). A little generous, as the
/// pixels decide for themselves.
__device__ inline bool meets_part(const SharedSplat& s, int x, int y) {
  const float least = least_power_in<float>({s.a.x, s.a.y}, {s.a.z, s.a.w, s.b.x}, float(x) + 0.5f,
                                            float(y) + 0.5f, float(kPart - 1), float(kPart - 1));
  // by the scaled conic, so times kExponent, which is negative
  return least >= kExponent * (s.c.y * 1.0001f + 1e-3f);
}

/// 2^x, relative error 2^-22.
__device__ inline float exp2_approximate(float x) {
  float result;
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
}

/// Response of a splat at a pixel: offset, scaled conic · offset, falloff, α  (splat_falloff).
struct PixelResponse {
  float dx, dy, gx, gy, falloff, alpha;

  __device__ PixelResponse(const SharedSplat& s, float x, float y) {  // pixel centre
    dx = s.a.x - x, dy = s.a.y - y;
    gx = s.a.z * dx + s.a.w * dy, gy = s.a.w * dx + s.b.x * dy;
    falloff = exp2_approximate(fminf(dx * gx + dy * gy, 0.0f));
    alpha = s.b.y * falloff;
  }
};

/// A warp's way through the splats of a tile, a bucket at a time; the next one is on its way while
/// this one is worked on.
class WarpSplats {
 public:
  /// Instances [first, first + count) of the tile; `mine`: this warp's 32 places in shared memory.
  __device__ WarpSplats(const Splat<float>* splats, const int32_t* instance, int32_t count,
                        SharedSplat* mine)
      : splats_(splats), instance_(instance), count_(count), mine_(mine) {
    fetch();
  }
  /// Puts the next bucket into shared memory. Returns a bit for each splat that may draw the part
  /// at (x, y); all that are listed without `Cull`.
  template <bool Cull>
  __device__ unsigned next_bucket(int x, int y) {
    const int lane = int(threadIdx.x) % 32;
    const bool listed = fetched_ + lane < count_;
    const bool meets = listed && (!Cull || meets_part(next_, x, y));
    number_ = next_number_;
    __syncwarp();  // the last bucket has been read
    if (meets) mine_[lane] = next_;
    __syncwarp();
    begin_ = fetched_;
    fetched_ += kBucket;
    fetch();
    return __ballot_sync(~0u, meets);
  }
  __device__ bool done() const { return fetched_ >= count_; }
  /// Place in the tile's list of the first splat of this bucket and of the next.
  __device__ int32_t begin() const { return begin_; }
  __device__ int32_t next_begin() const { return fetched_; }
  __device__ const SharedSplat& operator[](int i) const { return mine_[i]; }
  /// Number of the bucket's splat i in the batch; all lanes ask together.
  __device__ int32_t number(int i) const { return __shfl_sync(~0u, number_, i); }

 private:
  __device__ void fetch() {
    const int32_t i = fetched_ + int(threadIdx.x) % 32;
    if (i >= count_) return;
    next_number_ = instance_[i];
    next_ = SharedSplat::load(splats_ + next_number_);
  }

  const Splat<float>* splats_;
  const int32_t* instance_;
  int32_t count_, fetched_ = 0, begin_ = 0, number_ = 0, next_number_ = 0;
  SharedSplat* mine_;
  SharedSplat next_;
};

}  // namespace tessera
