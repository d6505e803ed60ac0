// What: front-to-back blending on the device: a block a tile, a warp an 8 × 8 part of it.
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
  const int32_t* tile_order;
  const Splat<float>* splats;
  float background[3];
  float* colour;
  float* transmittance;
  int32_t* used;
  float4* checkpoints;          // of the per-Gaussian backward pass
  const int64_t* bucket_begin;  // [tiles+1]
};

/// A pixel on its way through the splats.
struct PixelForward {
  float x, y;  // centre
  float T, red = 0, green = 0, blue = 0;
  int32_t used = 0;

  __device__ PixelForward(const TilePixel& at)
      : x(float(at.x) + 0.5f), y(float(at.y) + 0.5f), T(at.inside ? 1.0f : 0.0f) {}
  __device__ float4 state() const { return {red, green, blue, T}; }
  __device__ bool alive() const { return T >= kMinTransmittance<float>; }

  __device__ void blend(const SharedSplat& s, int32_t number) {
    const PixelResponse p(s, x, y);
    const bool on = p.alpha >= kMinAlpha<float> && alive();
    const float alpha = on ? p.alpha : 0.0f, weight = T * alpha;
    red += weight * s.b.z, green += weight * s.b.w, blue += weight * s.c.x;
    T *= 1.0f - alpha;
    used = on ? number : used;
  }
};

template <bool Cull, bool Checkpoint>
__global__ void __launch_bounds__(kTileThreads) blend_tiles(Blend a) {
  __shared__ SharedSplat shared[kTileWarps][kBucket];
  const int64_t tile = a.tile_order[blockIdx.x];
  const BatchTile at(a.views, a.view_count, tile);
  const int warp = int(threadIdx.x) / 32;
  const int part_x = at.part_x(warp), part_y = at.part_y(warp);
  PixelForward pixel[kLanePixels] = {TilePixel(at, pixel_of_thread(0)),
                                     TilePixel(at, pixel_of_thread(1))};
  const int64_t first = a.tile_begin[tile];
  WarpSplats splats(a.splats, a.instance + first, int32_t(a.tile_begin[tile + 1] - first),
                    shared[warp]);
  while (!splats.done() && __any_sync(~0u, pixel[0].alive() || pixel[1].alive())) {
    if constexpr (Checkpoint) {
      const int64_t bucket = a.bucket_begin[tile] + splats.next_begin() / kBucket;
      for (int p = 0; p < kLanePixels; ++p)
        a.checkpoints[bucket * kTilePixels + pixel_of_thread(p)] = pixel[p].state();
    }
    unsigned hits = splats.next_bucket<Cull>(part_x, part_y);
    for (; hits != 0; hits &= hits - 1) {
      const int i = __ffs(int(hits)) - 1;
      TESSERA_UNROLL
      for (int p = 0; p < kLanePixels; ++p) pixel[p].blend(splats[i], splats.begin() + i + 1);
    }
  }
  for (int p = 0; p < kLanePixels; ++p) {
    const TilePixel out(at, pixel_of_thread(p));
    if (!out.inside) continue;
    a.colour[out.colour_at(0)] = pixel[p].red + pixel[p].T * a.background[0];
    a.colour[out.colour_at(1)] = pixel[p].green + pixel[p].T * a.background[1];
    a.colour[out.colour_at(2)] = pixel[p].blue + pixel[p].T * a.background[2];
    a.transmittance[out.index] = pixel[p].T;
    a.used[out.index] = pixel[p].used;
  }
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
  checkpoints_.resize((args.instances->count / kBucket + tiles) * kTilePixels);
}

void CudaBackend::blend(const BlendArgs<float>& args, Images<float>& images) {
  const KernelSwitches& switches = args.options.kernels;
  images.colour.resize(3 * args.batch->pixels);
  images.transmittance.resize(args.batch->pixels);
  images.used.resize(args.batch->pixels);
  const bool keep = args.for_backward && switches.backward == BackwardForm::kPerGaussian;
  if (keep) reserve_checkpoints(args);
  Blend a{views_of(*args.batch),
          int(args.batch->views.size()),
          args.instances->tile_begin.data(),
          args.instances->splat.data(),
          args.instances->tile_order.data(),
          args.splats->splat.data(),
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
  const double checkpointed = keep ? 16.0 * kTilePixels / kBucket : 0.0;
  clock_.add_bytes(kBlend, double(args.instances->count) * (4 + 48 + checkpointed) +
                               20.0 * double(args.batch->pixels));
}

}  // namespace tessera
