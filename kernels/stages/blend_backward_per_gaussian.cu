// What: gradient of blending with lanes as splats: a warp takes a bucket of 32 of them, the tile's
// pixels pass from lane to lane with their T and R.
// Not: the default where parts of tiles can be skipped (blend_backward.cu); kept because which form
// wins depends on the card and on how large splats are.
// Source: [Taming], [Faster-GS]; scalar R: method A.11.
#include "kernels/cuda/blend_backward_args.cuh"
#include "kernels/cuda/device_error.h"

namespace tessera {
namespace {

constexpr int kWarps = 4;
constexpr int kRing = 64;  // pixels in flight: those of 32 lanes and the next 32

/// Pixels as they enter at lane 0; colour gradients stay here, T and R travel.
struct PixelRing {
  float T[kRing], R[kRing], g0[kRing], g1[kRing], g2[kRing];
  int32_t used[kRing];
};

/// Pixel number i of a tile, as thread i of a block has it.
__device__ inline void load_pixel(const BlendBackward& a, int64_t tile, int64_t bucket, int i,
                                  PixelRing& ring) {
  const BlockTile at(a.views, a.view_count, tile, i);
  const int slot = i % kRing;
  ring.used[slot] = 0;
  if (!at.inside) return;
  const float4 from = a.checkpoints[bucket * kTileThreads + i];
  const float g0 = a.d_colour[at.colour_at(0)], g1 = a.d_colour[at.colour_at(1)],
              g2 = a.d_colour[at.colour_at(2)];
  ring.g0[slot] = g0, ring.g1[slot] = g1, ring.g2[slot] = g2;
  ring.T[slot] = from.w;
  ring.R[slot] = g0 * (a.colour[at.colour_at(0)] - from.x) +
                 g1 * (a.colour[at.colour_at(1)] - from.y) +
                 g2 * (a.colour[at.colour_at(2)] - from.z);
  ring.used[slot] = a.used[at.view->first_pixel + at.pixel];
}

/// Tile of a bucket: the last whose buckets begin at or before it.
__device__ inline int64_t tile_of(const BlendBackward& a, int64_t bucket) {
  int64_t low = 0, high = a.tiles;
  while (high - low > 1) {
    const int64_t middle = (low + high) / 2;
    (a.bucket_begin[middle] <= bucket ? low : high) = middle;
  }
  return low;
}

__global__ void __launch_bounds__(32 * kWarps) backward_buckets(BlendBackward a) {
  __shared__ PixelRing rings[kWarps];
  PixelRing& ring = rings[threadIdx.x / 32];
  const int lane = int(threadIdx.x) % 32;
  const int64_t bucket = int64_t(blockIdx.x) * kWarps + threadIdx.x / 32;
  if (bucket >= a.bucket_begin[a.tiles]) return;
  const int64_t tile = tile_of(a, bucket);
  const int32_t index = int32_t(bucket - a.bucket_begin[tile]) * kBucket + lane;
  const int64_t first = a.tile_begin[tile];
  const bool listed = first + index < a.tile_begin[tile + 1];
  const int32_t number = listed ? a.instance[first + index] : 0;
  const SharedSplat s = a.splats[number];
  const BlockTile origin(a.views, a.view_count, tile, 0);
  float sum[kGradientTerms] = {};
  float T = 0, R = 0;
  for (int i = 0; i < kTileThreads + 31; ++i) {
    if (i % 32 == 0 && i < kTileThreads) {
      __syncwarp();
      load_pixel(a, tile, bucket, i + lane, ring);
      __syncwarp();
    }
    T = __shfl_up_sync(~0u, T, 1), R = __shfl_up_sync(~0u, R, 1);
    const int pixel = i - lane, slot = (pixel + kRing) % kRing;
    if (lane == 0 && i < kTileThreads) T = ring.T[slot], R = ring.R[slot];
    if (pixel < 0 || pixel >= kTileThreads || !listed || index >= ring.used[slot]) continue;
    const int part = pixel / 32, within = pixel % 32;
    constexpr int kParts = kTileSize / kPartWidth;
    const PixelResponse p(s, origin.x + part % kParts * kPartWidth + within % kPartWidth,
                          origin.y + part / kParts * kPartHeight + within / kPartWidth);
    if (p.alpha < kMinAlpha<float>) continue;
    float v[kGradientTerms];
    blend_step_backward(s, p, p.alpha, ring.g0[slot], ring.g1[slot], ring.g2[slot], T, R, v);
    TESSERA_UNROLL
    for (int k = 0; k < kGradientTerms; ++k) sum[k] += v[k];
  }
  if (!listed) return;
  float* out = reinterpret_cast<float*>(a.d_splats + number);
  for (int k = 0; k < kGradientTerms; ++k)
    if (sum[k] != 0.0f) atomicAdd(out + k, sum[k]);
}

}  // namespace

void launch_per_gaussian(const BlendBackward& args, int64_t instances, cudaStream_t stream) {
  const int64_t most = instances / kBucket + args.tiles;  // buckets
  backward_buckets<<<grid_of(most, kWarps), 32 * kWarps, 0, stream>>>(args);
}

}  // namespace tessera
