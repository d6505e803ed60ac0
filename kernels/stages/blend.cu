// What: front-to-back blending on the device: a block a tile, a warp an 8 × 4 part of it.
// Not: its gradient (blend_backward.cu).
// Source: [3DGS]; warp-level culling [Faster-GS]; method A.10.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/sort.h"
#include "kernels/cuda/tile_block.cuh"

namespace tessera {
namespace {

struct Blend {
  const ViewArgs<float>* views;
  int view_count;
  const int64_t* tile_begin;
  const int32_t* instance;
  const SharedSplat* splats;
  float background[3];
  float* colour;
  float* transmittance;
  int32_t* used;
  float4* checkpoints;          // of the per-Gaussian backward pass
  const int64_t* bucket_begin;  // [tiles+1]
};

template <bool Cull, bool Checkpoint>
__global__ void __launch_bounds__(kTileThreads) blend_tiles(Blend a) {
  __shared__ SharedSplat chunk[kTileThreads];
  const int64_t tile = blockIdx.x;
  const BlockTile at(a.views, a.view_count, tile, int(threadIdx.x));
  const int64_t first = a.tile_begin[tile], last = a.tile_begin[tile + 1];
  const int lane = int(threadIdx.x) % 32;
  float T = at.inside ? 1.0f : 0.0f;
  float red = 0, green = 0, blue = 0;
  int32_t used = 0;
  for (int64_t begin = first; begin < last; begin += kTileThreads) {
    if (__syncthreads_count(T >= kMinTransmittance<float>) == 0) break;
    const int count = int(min(int64_t(kTileThreads), last - begin));
    if (int(threadIdx.x) < count) chunk[threadIdx.x] = a.splats[a.instance[begin + threadIdx.x]];
    __syncthreads();
    for (int group = 0; group < count; group += kBucket) {
      if constexpr (Checkpoint) {
        const int64_t bucket = a.bucket_begin[tile] + (begin - first + group) / kBucket;
        a.checkpoints[bucket * kTileThreads + threadIdx.x] = {red, green, blue, T};
      } else if (!__any_sync(~0u, T >= kMinTransmittance<float>)) {
        break;
      }
      const bool listed = group + lane < count;
      unsigned hits = __ballot_sync(
          ~0u, listed && (!Cull || meets_part(chunk[group + lane], at.part_x, at.part_y)));
      for (; hits != 0; hits &= hits - 1) {
        const int i = group + __ffs(int(hits)) - 1;
        const SharedSplat& s = chunk[i];
        const PixelResponse p(s, at.x, at.y);
        if (p.alpha < kMinAlpha<float> || T < kMinTransmittance<float>) continue;
        const float weight = T * p.alpha;
        red += weight * s.b.z, green += weight * s.b.w, blue += weight * s.c.x;
        T *= 1.0f - p.alpha;
        used = int32_t(begin - first) + i + 1;
      }
    }
  }
  if (!at.inside) return;
  a.colour[at.colour_at(0)] = red + T * a.background[0];
  a.colour[at.colour_at(1)] = green + T * a.background[1];
  a.colour[at.colour_at(2)] = blue + T * a.background[2];
  a.transmittance[at.view->first_pixel + at.pixel] = T;
  a.used[at.view->first_pixel + at.pixel] = used;
}

__global__ void count_buckets(const int64_t* tile_begin, int64_t tiles, int32_t* buckets) {
  const int64_t t = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (t < tiles) buckets[t] = int32_t((tile_begin[t + 1] - tile_begin[t] + kBucket - 1) / kBucket);
}

}  // namespace

void CudaBackend::reserve_checkpoints(const BlendArgs<float>& args) {
  const int64_t tiles = args.batch->tiles;
  Buffer<int32_t> buckets(tiles, memory_);
  count_buckets<<<grid_of(tiles, 256), 256, 0, stream_>>>(args.instances->tile_begin.data(), tiles,
                                                          buckets.data());
  bucket_begin_.resize(tiles + 1);
  exclusive_sums(stream_, buckets.span(), bucket_begin_.span(), sort_scratch_);
  // every tile's last bucket may be incomplete: no more than this, whatever the lists are
  checkpoints_.resize((args.instances->count / kBucket + tiles) * kTileThreads);
}

void CudaBackend::blend(const BlendArgs<float>& args, Images<float>& images) {
  const KernelSwitches& switches = args.options.kernels;
  images.colour.resize(3 * args.batch->pixels);
  images.transmittance.resize(args.batch->pixels);
  images.used.resize(args.batch->pixels);
  const bool keep = args.for_backward && switches.backward == BackwardForm::kPerGaussian;
  if (keep) reserve_checkpoints(args);
  Blend a{views_.data(),
          int(args.batch->views.size()),
          args.instances->tile_begin.data(),
          args.instances->splat.data(),
          reinterpret_cast<const SharedSplat*>(args.splats->splat.data()),
          {},
          images.colour.data(),
          images.transmittance.data(),
          images.used.data(),
          checkpoints_.data(),
          bucket_begin_.data()};
  for (int c = 0; c < 3; ++c) a.background[c] = float(args.options.background[c]);
  const auto kernel = switches.warp_culling ? (keep ? blend_tiles<true, true> : blend_tiles<true, false>)
                                            : (keep ? blend_tiles<false, true> : blend_tiles<false, false>);
  kernel<<<grid_of(args.batch->tiles, 1), kTileThreads, 0, stream_>>>(a);
  check_launch("blend: blend_tiles");
  const double checkpointed = keep ? 16.0 * kTileThreads / kBucket : 0.0;
  clock_.add_bytes(kBlend, double(args.instances->count) * (4 + 48 + checkpointed) +
                               20.0 * double(args.batch->pixels));
}

}  // namespace tessera
