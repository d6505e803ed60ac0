// What: what all sums over a splat's pixels read and write; a pixel's step of the gradient.
// Not: the forms of the walk (splat_sums.cuh, blend_backward_per_gaussian.cu).
#pragma once
#include "kernels/cuda/tile_block.cuh"

namespace tessera {

inline constexpr int kSegment = 128;      // splats between two checkpoints where lists are cut
inline constexpr int kGradientTerms = 9;  // floats of a SplatGradient
static_assert(sizeof(SplatGradient<float>) == kGradientTerms * sizeof(float));

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
  static constexpr int kTerms = kGradientTerms;
  float x = 0, y = 0;  // centre
  float T = 1, R = 0;  // light that is left; ⟨colour still to come, dL/dC⟩
  float g0 = 0, g1 = 0, g2 = 0;
  int32_t used = 0;

  __device__ PixelBackward() = default;
  /// `before`: colour and T in front of the first splat it meets.
  __device__ PixelBackward(const BlendBackward& a, const TilePixel& at, const float4& before)
      : x(float(at.x) + 0.5f), y(float(at.y) + 0.5f), T(before.w) {
    if (!at.inside) return;
    const int64_t c0 = at.colour_at(0), c1 = at.colour_at(1), c2 = at.colour_at(2);
    g0 = a.d_colour[c0], g1 = a.d_colour[c1], g2 = a.d_colour[c2];
    R = g0 * (a.colour[c0] - before.x) + g1 * (a.colour[c1] - before.y) +
        g2 * (a.colour[c2] - before.z);
    used = a.used[at.index];
  }

  /// Takes its step past a splat and adds its share of the splat's gradient, in the order of
  /// SplatGradient but for the factors of `scale`.
  __device__ void step(const SharedSplat& s, const PixelResponse& p, bool on,
                       float (&v)[kGradientTerms]) {
    const float alpha = on ? p.alpha : 0.0f;
    const float weight = T * alpha, rest = 1.0f - alpha;
    const float kappa = s.b.z * g0 + s.b.w * g1 + s.c.x * g2;
    R -= weight * kappa;
    const float beyond = __fdividef(R, fmaxf(rest, kMinOneMinusAlpha<float>));
    const float d_alpha = on ? T * kappa - beyond : 0.0f;
    T *= rest;
    const float h = -alpha * d_alpha, hx = h * p.dx, hy = h * p.dy;
    v[0] += h * p.gx, v[1] += h * p.gy;
    v[2] += hx * p.dx, v[3] += hx * p.dy, v[4] += hy * p.dy;
    v[5] += p.falloff * d_alpha;
    v[6] += weight * g0, v[7] += weight * g1, v[8] += weight * g2;
  }
  /// What sums of `step` still have to be multiplied with.
  __device__ static float scale(int term) {
    return term < 2 ? 1.0f / kExponent : term < 5 ? 0.5f : 1.0f;
  }
};

/// Lanes as splats; needs checkpoints.
void launch_per_gaussian(const BlendBackward& args, int64_t instances, cudaStream_t stream);

}  // namespace tessera
