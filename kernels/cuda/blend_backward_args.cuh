// What: what all sums over a splat's pixels read and write; a pixel's step of the gradient.
// Not: the walk (splat_sums.cuh).
#pragma once
#include "kernels/cuda/tile_block.cuh"

namespace tessera {

inline constexpr int kSegment = 128;  // splats between two checkpoints where lists are cut
static_assert(sizeof(SplatGradient<float>) == kSplatGradientTerms * sizeof(float));

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

/// A pixel on its way back through the splats.
struct PixelBackward {
  using Args = BlendBackward;
  static constexpr int kTerms = kSplatGradientTerms;
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

  /// Takes its step past a splat and adds its share of the splat's gradient, in the order of
  /// SplatGradient but for the factors of `scale`.
  __device__ void step(const SharedSplat& s, const PixelResponse& p, bool on,
                       float (&v)[kSplatGradientTerms]) {
    blend_backward_step(p, on, s.colour(), g, T, R, [&](int k, float term) { v[k] += term; });
  }
  /// What sums of `step` still have to be multiplied with.
  __device__ static float scale(int term) {
    return term < 2 ? 1.0f / kExponent : term < 5 ? 0.5f : 1.0f;
  }
};

}  // namespace tessera
