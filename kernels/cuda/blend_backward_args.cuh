// Arguments of the sums over the pixels of a splat, the step of one pixel in the gradient of
// blending, and sums over the lanes of a warp.
#pragma once
#include <cstdint>

#include "kernels/base/host_device.h"
#include "kernels/cuda/tile_block.cuh"

namespace tessera {

/// Of two values the second in lanes whose number has `Bit`, else the first. In assembly, for which
/// all bits of a lane become predicates in one instruction; left to itself the compiler takes three
/// for each.
template <int Bit>
__device__ inline float by_bit(int lane, float first, float second) {
  float chosen;
  asm("{\n\t"
      ".reg .pred has;\n\t"
      ".reg .b32 bit;\n\t"
      "and.b32 bit, %3, %4;\n\t"
      "setp.ne.b32 has, bit, 0;\n\t"
      "selp.f32 %0, %2, %1, has;\n\t"
      "}"
      : "=f"(chosen)
      : "f"(first), "f"(second), "r"(lane), "n"(Bit));
  return chosen;
}

/// The value that by_bit keeps, with what the lane that differs by `Bit` had of it.
template <int Bit>
__device__ inline float exchange(int lane, float first, float second) {
  return by_bit<Bit>(lane, first, second) +
         __shfl_xor_sync(~0u, by_bit<Bit>(lane, second, first), Bit);
}

/// Sums up to eight values over a warp: lane l ends with the total of value l / 4.
template <int Terms>
__device__ inline float reduce_eight(const float (&v)[Terms]) {
  static_assert(Terms >= 4 && Terms <= 8);
  const int lane = int(threadIdx.x) % 32;
  float w[4];
  TESSERA_UNROLL
  for (int k = 0; k < 4; ++k) w[k] = exchange<16>(lane, v[k], k + 4 < Terms ? v[k + 4] : 0.0f);
  const float u0 = exchange<8>(lane, w[0], w[2]), u1 = exchange<8>(lane, w[1], w[3]);
  float sum = exchange<4>(lane, u0, u1);
  sum += __shfl_xor_sync(~0u, sum, 2);
  return sum + __shfl_xor_sync(~0u, sum, 1);
}

/// In every lane.
__device__ inline int32_t largest_of_warp(int32_t v) {
  TESSERA_UNROLL
  for (int step = 16; step > 0; step /= 2) v = max(v, __shfl_xor_sync(~0u, v, step));
  return v;
}

inline constexpr int kSegment = 128;  // splats between two checkpoints where lists are cut
static_assert(sizeof(SplatMoments<float>) == kSplatMomentTerms * sizeof(float));

struct BlendBackward {
  const ViewArgs<float>* views;
  int view_count;
  const int64_t* tile_begin;
  const int32_t* instance;
  const int32_t* tile_order;
  int64_t instances;  // I
  const Splat<float>* splats;
  Cutoff<float> cutoff;
  const float* colour;    // the image, background included
  const float* d_colour;  // planar as the image
  const int32_t* used;
  float* sums;                  // [S, terms] added to
  float* lengths;               // [S] added to, or null
  float* instance_sums;         // [parts, I, terms] when they are added in order
  const float4* checkpoints;    // [buckets · 256] colour and T
  const int64_t* bucket_begin;  // [tiles+1]
  int64_t tiles;

  /// Tile of a bucket: the last whose buckets begin at or before it.
  __device__ int64_t tile_of_bucket(int64_t bucket) const {
    int64_t low = 0, high = tiles;
    while (high - low > 1) {
      const int64_t middle = (low + high) / 2;
      (bucket_begin[middle] <= bucket ? low : high) = middle;
    }
    return low;
  }
};

/// How the shares of pixels become the sums of a splat.
template <int Terms>
struct AddedTerms {
  __device__ static float combine(float a, float b) { return a + b; }
  __device__ static void give(const BlendBackward&, float* to, int32_t splat, float total) {
    atomicAdd(to + int64_t(splat) * Terms, total);
  }
  __device__ static float& sum(const BlendBackward& a, int64_t splat, int term) {
    return a.sums[splat * Terms + term];
  }
};

/// A pixel on its way back through the splats.
struct PixelBackward : AddedTerms<kSplatMomentTerms> {
  using Args = BlendBackward;
  static constexpr int kLaneTerms = kColumnTerms, kTerms = kSplatMomentTerms;
  float x = 0, y = 0;               // centre
  float T = 1, R = 0;               // light that is left; ⟨colour still to come, dL/dC⟩
  Vec3<float> g{0.0f, 0.0f, 0.0f};  // dL/dC
  int32_t used = 0;

  __device__ PixelBackward() = default;
  /// `before`: colour and T in front of the first splat it meets.
  __device__ PixelBackward(const BlendBackward& a, const TilePixel& tile_pixel,
                           const float4& before)
      : x(float(tile_pixel.x) + 0.5f), y(float(tile_pixel.y) + 0.5f), T(before.w) {
    if (!tile_pixel.inside) return;
    const int64_t c0 = tile_pixel.colour_at(0), c1 = tile_pixel.colour_at(1),
                  c2 = tile_pixel.colour_at(2);
    g = {a.d_colour[c0], a.d_colour[c1], a.d_colour[c2]};
    R = g[0] * (a.colour[c0] - before.x) + g[1] * (a.colour[c1] - before.y) +
        g[2] * (a.colour[c2] - before.z);
    used = a.used[tile_pixel.index];
  }

  /// Takes its step past a splat; calls add(k, term) with its share of its lane's sums.
  template <class Add>
  __device__ void step(const SharedSplat& s, const PixelResponse& p, bool on, Add&& add) {
    blend_backward_step(s.opacity(), on ? p.falloff : 0.0f, p.dy, s.colour(), g, T, R, add);
  }
  /// Down the columns first, which share dx: the moments by dx follow from their sums
  /// (column_moments). A warp has 8 columns of 4 lanes.
  __device__ static float reduce(float dx, const float (&v)[kLaneTerms]) {
    return reduce_columns(dx, v, [](int, float w) { return w + __shfl_xor_sync(~0u, w, 8); });
  }
  /// `whole`(lane, w): f·dy² or blue of a column from that of half a column, in lanes of which bits
  /// 3 and 4 differ; what the others have becomes the total of the lane that has no term.
  template <int Terms, class Whole>
  __device__ static float reduce_columns(float dx, const float (&v)[Terms], Whole&& whole) {
    const int lane = int(threadIdx.x) % 32;
    float w[3];  // f, f·dy, f·dy² or red, green, blue, of half a column
    TESSERA_UNROLL
    for (int k = 0; k < 3; ++k) w[k] = exchange<16>(lane, v[k], v[k + 3]);
    const float a = exchange<8>(lane, w[0], w[1]);  // f, f·dy or red, green of a column
    const float b = whole(lane, w[2]);
    const float a_dx = a * dx;
    const float p = exchange<4>(lane, a, by_bit<16>(lane, a_dx, b));
    const float t = by_bit<8>(lane, a_dx * dx, b);
    const float q = t + __shfl_xor_sync(~0u, t, 4);
    const float sum = exchange<2>(lane, p, q);
    return sum + __shfl_xor_sync(~0u, sum, 1);
  }
  /// In the order of SplatMoments.
  __device__ static int term_of_lane() {
    //                              f  f·dx        f·dy           r  b        g
    constexpr int kTerm[16] = {0, 3, 1, 9, 2, 5, 4, 9, 6, 9, 8, 9, 7, 9, 9, 9};
    const int lane = int(threadIdx.x) % 32;
    return lane % 2 == 0 ? kTerm[lane / 2] : kTerms;
  }
};

/// √x, relative error 2^-22.
__device__ inline float sqrt_approximate(float x) {
  float result;
  asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
}

/// And the sum over pixels of the lengths of their gradients by the splat's place (slope_length),
/// in a lane that has none of the other terms.
struct PixelBackwardAndLength : PixelBackward {
  static constexpr int kLaneTerms = kColumnTerms + 1, kTerms = kSplatMomentTerms + 1;
  static constexpr int kLengthLane = 28;

  using PixelBackward::PixelBackward;

  template <class Add>
  __device__ void step(const SharedSplat& s, const PixelResponse& p, bool on, Add&& add) {
    const float dx = s.a.x - x, xy = 0.5f * s.a.w;
    const float along_x = s.a.z * dx + xy * p.dy, along_y = xy * dx + s.b.x * p.dy;
    const float length = sqrt_approximate(along_x * along_x + along_y * along_y) / -kExponent;
    PixelBackward::step(s, p, on, [&](int k, float term) {
      add(k, term);
      if (k == 0) add(kColumnTerms, abs_of(term) * length);
    });
  }
  __device__ static float reduce(float dx, const float (&v)[kLaneTerms]) {
    const float length = v[kColumnTerms] + __shfl_xor_sync(~0u, v[kColumnTerms], 16);
    return reduce_columns(dx, v, [&](int lane, float w) {
      const bool differ = ((lane ^ lane >> 1) & 8) != 0;
      return (differ ? w : length) + __shfl_xor_sync(~0u, differ ? length : w, 8);
    });
  }
  __device__ static int term_of_lane() {
    if (int(threadIdx.x) % 32 == kLengthLane) return kSplatMomentTerms;
    const int term = PixelBackward::term_of_lane();
    return term < kSplatMomentTerms ? term : kTerms;
  }
  __device__ static void give(const BlendBackward& a, float* to, int32_t splat, float total) {
    if (int(threadIdx.x) % 32 == kLengthLane)
      atomicAdd(a.lengths + splat, total);
    else
      PixelBackward::give(a, to, splat, total);
  }
  __device__ static float& sum(const BlendBackward& a, int64_t splat, int term) {
    return term == kSplatMomentTerms ? a.lengths[splat] : PixelBackward::sum(a, splat, term);
  }
};

}  // namespace tessera
