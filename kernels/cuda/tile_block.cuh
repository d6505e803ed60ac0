// The layout of warps over a tile: a warp has a part of the tile and a lane has one or two pixels.
// Each warp goes through the splats of the tile, 32 at a time, without waiting for other warps.
// Source: sub-tiles of [Faster-GS]; method A.10, G.4.
#pragma once
#include "kernels/batch.h"

namespace tessera {

inline constexpr int kTilePixels = kTileSize * kTileSize;
inline constexpr int kBucket = 32;    // splats that a warp takes at a time
inline constexpr int kPartWidth = 8;  // pixels of a warp's part

/// A tile cut into parts for lanes of `Pixels` pixels, one above the other.
template <int Pixels>
struct TileParts {
  static constexpr int kHeight = 4 * Pixels;  // of a part
  static constexpr int kColumns = kTileSize / kPartWidth;
  static constexpr int kWarps = kTilePixels / (32 * Pixels);
  static constexpr int kThreads = 32 * kWarps;
};

/// A tile of the batch.
struct BatchTile {
  const ViewArgs<float>* view;
  int x0, y0;  // first pixel

  __device__ BatchTile(const ViewArgs<float>* views, int view_count, int64_t tile) {
    int b = 0;
    while (b + 1 < view_count && tile >= views[b + 1].first_tile) ++b;
    view = views + b;
    const int local = int(tile - view->first_tile);
    x0 = local % view->tiles_x * kTileSize;
    y0 = local / view->tiles_x * kTileSize;
  }
};

/// A pixel of a tile.
struct TilePixel {
  int x, y;
  int number;     // within the tile, row by row
  bool inside;    // of the image
  int64_t index;  // within the batch's one-channel images
  int64_t first_colour, plane;
  const ViewArgs<float>* image;

  /// (dx, dy): within the tile.
  __device__ TilePixel(const BatchTile& tile, int dx, int dy)
      : x(tile.x0 + dx), y(tile.y0 + dy), number(dy * kTileSize + dx), image(tile.view) {
    const ViewArgs<float>& view = *tile.view;
    inside = x < view.width && y < view.height;
    plane = int64_t(view.width) * view.height;
    const int64_t within = int64_t(y) * view.width + x;
    index = view.first_pixel + within;
    first_colour = 3 * view.first_pixel + within;
  }
  /// Index of channel c in a planar image of the batch.
  __device__ int64_t colour_at(int c) const { return first_colour + c * plane; }
};

/// The part of a tile that a warp has.
template <int Pixels>
struct WarpPart {
  using Parts = TileParts<Pixels>;
  const BatchTile& tile;
  int dx, dy;  // of its first pixel, within the tile

  __device__ WarpPart(const BatchTile& batch_tile) : tile(batch_tile) {
    const int warp = int(threadIdx.x) / 32;
    dx = warp % Parts::kColumns * kPartWidth;
    dy = warp / Parts::kColumns * Parts::kHeight;
  }
  /// Pixel p of this lane.
  __device__ TilePixel pixel(int p) const {
    const int lane = int(threadIdx.x) % 32;
    return {tile, dx + lane % kPartWidth, dy + 4 * p + lane / kPartWidth};
  }
};

/// exp(−½ x) = 2^(kExponent·x).
inline constexpr float kExponent = -0.5f * 1.44269504088896341f;

/// What blending reads of a splat, 48 bytes as three vectors, its conic times kExponent. In shared
/// memory some fields are others: what the pixels of a part need of them.
struct alignas(16) SharedSplat {
  float4 a;  // mean2d, conic xx, xy; shared: 2·xy
  float4 b;  // conic yy, opacity, colour r, g
  float4 c;  // colour b, power, view, negative; shared: colour b, least G drawn, number

  __device__ float opacity() const { return b.y; }
  __device__ Vec3<float> colour() const { return {b.z, b.w, c.x}; }
  /// In shared memory: where G is less the splat is not drawn.
  __device__ float least_falloff() const { return c.y; }
  /// In shared memory: of the splat, in the batch.
  __device__ int32_t number() const { return __float_as_int(c.z); }
  __device__ static SharedSplat load(const Splat<float>* splat) {
    const float4* from = reinterpret_cast<const float4*>(splat);
    SharedSplat s{from[0], from[1], from[2]};
    s.a.z *= kExponent;
    s.a.w *= kExponent;
    s.b.x *= kExponent;
    return s;
  }
};
static_assert(sizeof(SharedSplat) == sizeof(Splat<float>));

/// Whether a splat may draw a pixel of the part. A little generous, as the pixels decide for
/// themselves.
template <int Pixels>
__device__ inline bool meets_part(const SharedSplat& s, const WarpPart<Pixels>& part) {
  const float least = least_power_in<float>(
      {s.a.x, s.a.y}, {s.a.z, s.a.w, s.b.x}, float(part.tile.x0 + part.dx) + 0.5f,
      float(part.tile.y0 + part.dy) + 0.5f, float(kPartWidth - 1),
      float(TileParts<Pixels>::kHeight - 1));
  // by the scaled conic, so times kExponent, which is negative
  return least >= kExponent * (s.c.y * 1.0001f + 1e-3f);
}

/// 2^x, relative error 2^-22.
__device__ inline float exp2_approximate(float x) {
  float result;
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
}

/// What the pixels of a column have in common: the exponent is a parabola of dy.
struct ColumnResponse {
  float dx;                // mean2d − pixel centre
  float constant, linear;  // exponent = constant + (linear + conic yy·dy)·dy

  __device__ ColumnResponse(const SharedSplat& s, float x)
      : dx(s.a.x - x), constant(s.a.z * dx * dx), linear(s.a.w * dx) {}
};

/// Response of a splat at a pixel  (splat_falloff).
struct PixelResponse {
  float dy;       // mean2d − pixel centre
  float falloff;  // G

  __device__ PixelResponse() {}
  __device__ PixelResponse(const SharedSplat& s, const ColumnResponse& column, float y)
      : dy(s.a.y - y) {
    // left to itself the compiler contracts the constant and pays two instructions more a pixel
    const float exponent = fmaf(fmaf(s.b.x, dy, column.linear), dy, column.constant);
    falloff = exp2_approximate(fminf(exponent, 0.0f));
  }
  /// Cutoff::draws, of both comparisons the one that decides.
  __device__ bool drawn(const SharedSplat& s) const { return falloff >= s.least_falloff(); }
};

/// A warp's way through the splats of a tile, a bucket at a time. The next bucket's records and the
/// numbers of the one after it are on their way while this one is worked on.
class WarpSplats {
 public:
  /// Places [begin, end) of the list at `instance`; `shared`: this warp's 32 places in shared
  /// memory.
  __device__ WarpSplats(const Splat<float>* splats, const Cutoff<float>& cutoff,
                        const int32_t* instance, int32_t begin, int32_t end, SharedSplat* shared)
      : splats_(splats),
        cutoff_(cutoff),
        instance_(instance),
        end_(end),
        next_(begin),
        shared_(shared) {
    fetch_number(begin);
    fetch_record();
    fetch_number(begin + kBucket);
  }
  /// Puts the next bucket into shared memory. Returns a bit for each splat that may draw the part;
  /// all that are listed without `Cull`.
  template <bool Cull, int Pixels>
  __device__ unsigned next_bucket(const WarpPart<Pixels>& part) {
    const int lane = int(threadIdx.x) % 32;
    const bool listed = next_ + lane < end_;
    const bool meets = listed && (!Cull || meets_part(record_, part));
    __syncwarp();  // the last bucket has been read
    record_.a.w *= 2.0f;
    record_.c.y = fmaxf(fast_divide(cutoff_.least_alpha, record_.b.y), cutoff_.least_falloff);
    record_.c.z = __int_as_float(record_number_);
    if (meets) shared_[lane] = record_;
    __syncwarp();
    begin_ = next_;
    next_ += kBucket;
    fetch_record();
    fetch_number(next_ + kBucket);
    return __ballot_sync(~0u, meets);
  }
  __device__ bool done() const { return next_ >= end_; }
  /// Place in the tile's list of the first splat of this bucket and of the next.
  __device__ int32_t begin() const { return begin_; }
  __device__ int32_t next_begin() const { return next_; }
  __device__ const SharedSplat& operator[](int i) const { return shared_[i]; }

 private:
  __device__ void fetch_number(int32_t bucket) {
    const int32_t i = bucket + int(threadIdx.x) % 32;
    next_number_ = i < end_ ? instance_[i] : -1;
  }
  __device__ void fetch_record() {
    record_number_ = next_number_;
    if (record_number_ >= 0) record_ = SharedSplat::load(splats_ + record_number_);
  }

  const Splat<float>* splats_;
  const Cutoff<float>& cutoff_;
  const int32_t* instance_;
  int32_t end_, next_, begin_ = 0, record_number_ = 0, next_number_ = 0;
  SharedSplat* shared_;
  SharedSplat record_;
};

}  // namespace tessera
