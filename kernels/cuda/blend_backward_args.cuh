// What: what both forms of the gradient of blending read and write.
// Not: either form.
#pragma once
#include "kernels/cuda/tile_block.cuh"

namespace tessera {

inline constexpr int kGradientTerms = 9;  // floats of a SplatGradient
static_assert(sizeof(SplatGradient<float>) == kGradientTerms * sizeof(float));

struct BlendBackward {
  const ViewArgs<float>* views;
  int view_count;
  const int64_t* tile_begin;
  const int32_t* instance;
  const SharedSplat* splats;
  const float* colour;    // the picture, background included
  const float* d_colour;  // planar as the picture
  const int32_t* used;
  SplatGradient<float>* d_splats;     // added to
  SplatGradient<float>* d_instances;  // [I] when they are added in order
  const float4* checkpoints;          // [buckets · 256] colour and T
  const int64_t* bucket_begin;        // [tiles+1]
  int64_t tiles;
};

/// A pixel takes its step past a splat: T and R advance, and its share of the splat's gradient comes
/// out in the order of SplatGradient. `alpha` is 0 where the splat is not drawn.
__device__ inline void blend_step_backward(const SharedSplat& s, const PixelResponse& p,
                                           float alpha, float g0, float g1, float g2, float& T,
                                           float& R, float (&v)[kGradientTerms]) {
  const float weight = T * alpha, rest = 1.0f - alpha;
  const float kappa = s.b.z * g0 + s.b.w * g1 + s.c.x * g2;
  R -= weight * kappa;
  const float beyond = __fdividef(R, fmaxf(rest, kMinOneMinusAlpha<float>));
  const float d_alpha = alpha > 0.0f ? T * kappa - beyond : 0.0f;
  T *= rest;
  const float h = -alpha * d_alpha, half = 0.5f * h;
  v[0] = h * p.gx, v[1] = h * p.gy;
  v[2] = half * p.dx * p.dx, v[3] = half * p.dx * p.dy, v[4] = half * p.dy * p.dy;
  v[5] = p.falloff * d_alpha;
  v[6] = weight * g0, v[7] = weight * g1, v[8] = weight * g2;
}

/// Lanes as splats; needs checkpoints.
void launch_per_gaussian(const BlendBackward& args, int64_t instances, cudaStream_t stream);

}  // namespace tessera
