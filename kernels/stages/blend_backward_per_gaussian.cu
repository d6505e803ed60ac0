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
/// Pixels in flight: those of 32 lanes and the next 32. They enter at lane 0; T and R then travel
/// from lane to lane, the rest stays.
constexpr int kRing = 64;

__global__ void __launch_bounds__(32 * kWarps) backward_buckets(BlendBackward a) {
  __shared__ PixelBackward rings[kWarps][kRing];
  PixelBackward* const ring = rings[threadIdx.x / 32];
  const int lane = int(threadIdx.x) % 32;
  const int64_t bucket = int64_t(blockIdx.x) * kWarps + threadIdx.x / 32;
  if (bucket >= a.bucket_begin[a.tiles]) return;
  const int64_t tile = a.tile_of_bucket(bucket);
  const int32_t index = int32_t(bucket - a.bucket_begin[tile]) * kBucket + lane;
  const int64_t first = a.tile_begin[tile];
  const bool listed = first + index < a.tile_begin[tile + 1];
  const int32_t number = listed ? a.instance[first + index] : 0;
  const SharedSplat s = SharedSplat::load(a.splats + number);
  const BatchTile at(a.views, a.view_count, tile);
  float sum[kGradientTerms] = {};
  float T = 0, R = 0;
  for (int i = 0; i < kTilePixels + 31; ++i) {
    if (i % 32 == 0 && i < kTilePixels) {
      __syncwarp();
      const int number = i + lane;
      ring[number % kRing] = PixelBackward(a, TilePixel(at, number % kTileSize, number / kTileSize),
                                           a.checkpoints[bucket * kTilePixels + number]);
      __syncwarp();
    }
    T = __shfl_up_sync(~0u, T, 1), R = __shfl_up_sync(~0u, R, 1);
    const int from = i - lane;
    PixelBackward pixel = ring[(from + kRing) % kRing];
    if (lane != 0) pixel.T = T, pixel.R = R;
    if (from >= 0 && from < kTilePixels && listed && index < pixel.used) {
      const PixelResponse p(s, pixel.x, pixel.y);
      if (a.cutoff.draws(p.alpha, p.falloff)) pixel.step(s, p, true, sum);
    }
    T = pixel.T, R = pixel.R;
  }
  if (!listed) return;
  float* out = a.sums + int64_t(number) * kGradientTerms;
  TESSERA_UNROLL
  for (int k = 0; k < kGradientTerms; ++k)
    if (sum[k] != 0.0f) atomicAdd(out + k, sum[k] * PixelBackward::scale(k));
}

}  // namespace

void launch_per_gaussian(const BlendBackward& args, int64_t instances, cudaStream_t stream) {
  const int64_t most = instances / kBucket + args.tiles;  // buckets
  backward_buckets<<<grid_of(most, kWarps), 32 * kWarps, 0, stream>>>(args);
}

}  // namespace tessera
