// Front-to-back blending on the device: a block has a tile, and a warp has a part of it. Source:
// [3DGS]; warp-level culling [Faster-GS]; method A.10, C.3.
#include "kernels/base/errors.h"
#include "kernels/cuda/blend_backward_args.cuh"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/sort.h"

namespace tessera {
namespace {

struct Blend {
  const ViewArgs<float>* views;
  int view_count;
  const int64_t* tile_begin;
  const int32_t* instance;
  const int32_t* tile_order;
  const Splat<float>* splats;
  Cutoff<float> cutoff;
  float background[3];
  float* colour;
  float* transmittance;
  int32_t* used;
  float4* checkpoints;          // [checkpoints, 256] colour and T
  const int64_t* bucket_begin;  // [tiles+1] first of each tile
};

/// A pixel on its way through the splats.
struct PixelForward {
  float x, y;  // centre
  float T, red = 0, green = 0, blue = 0;
  int32_t used = 0;

  __device__ PixelForward() {}
  __device__ explicit PixelForward(const TilePixel& tile_pixel)
      : x(float(tile_pixel.x) + 0.5f),
        y(float(tile_pixel.y) + 0.5f),
        T(tile_pixel.inside ? 1.0f : 0.0f) {}
  __device__ float4 state() const { return {red, green, blue, T}; }
  __device__ bool alive() const { return T >= kMinTransmittance<float>; }

  __device__ void blend(const SharedSplat& s, const ColumnResponse& column, int32_t number) {
    const PixelResponse p(s, column, y);
    const bool on = p.drawn(s) && alive();
    blend_step(on ? s.opacity() * p.falloff : 0.0f, s.colour(), red, green, blue, T);
    used = on ? number : used;
  }
};

template <int Pixels, bool Cull, bool Checkpoint>
__global__ void __launch_bounds__(TileParts<Pixels>::kThreads) blend_tiles(Blend a) {
  __shared__ SharedSplat shared[TileParts<Pixels>::kWarps][kBucket];
  const int64_t tile = a.tile_order[blockIdx.x];
  const BatchTile batch_tile(a.views, a.view_count, tile);
  const WarpPart<Pixels> part(batch_tile);
  PixelForward pixel[Pixels];
  TESSERA_UNROLL
  for (int p = 0; p < Pixels; ++p) pixel[p] = PixelForward(part.pixel(p));
  const auto alive = [&] {
    bool any = false;
    for (int p = 0; p < Pixels; ++p) any = any || pixel[p].alive();
    return any;
  };
  const int64_t first = a.tile_begin[tile];
  WarpSplats splats(a.splats, a.cutoff, a.instance + first, 0,
                    int32_t(a.tile_begin[tile + 1] - first), shared[threadIdx.x / 32]);
  while (!splats.done() && __any_sync(~0u, alive())) {
    if (Checkpoint && splats.next_begin() % kSegment == 0) {
      const int64_t bucket = a.bucket_begin[tile] + splats.next_begin() / kSegment;
      for (int p = 0; p < Pixels; ++p)
        a.checkpoints[bucket * kTilePixels + part.pixel(p).number] = pixel[p].state();
    }
    unsigned hits = splats.next_bucket<Cull>(part);
    for (; hits != 0; hits &= hits - 1) {
      const int i = __ffs(int(hits)) - 1;
      const ColumnResponse column(splats[i], pixel[0].x);
      TESSERA_UNROLL
      for (int p = 0; p < Pixels; ++p) pixel[p].blend(splats[i], column, splats.begin() + i + 1);
    }
  }
  TESSERA_UNROLL
  for (int p = 0; p < Pixels; ++p) {
    const TilePixel out = part.pixel(p);
    if (!out.inside) continue;
    a.colour[out.colour_at(0)] = pixel[p].red + pixel[p].T * a.background[0];
    a.colour[out.colour_at(1)] = pixel[p].green + pixel[p].T * a.background[1];
    a.colour[out.colour_at(2)] = pixel[p].blue + pixel[p].T * a.background[2];
    a.transmittance[out.index] = pixel[p].T;
    a.used[out.index] = pixel[p].used;
  }
}

__global__ void count_buckets(const int64_t* tile_begin, int64_t tiles, int32_t* buckets) {
  const int64_t t = linear_index();
  if (t < tiles)
    buckets[t] = int32_t((tile_begin[t + 1] - tile_begin[t] + kSegment - 1) / kSegment);
}

}  // namespace

void CudaBackend::reserve_checkpoints(const BlendArgs<float>& args) {
  const int64_t tiles = args.batch->tiles;
  Buffer<int32_t> buckets(tiles, memory_);
  launch_linear<256>(stream_, "blend: count_buckets", count_buckets, tiles,
                     args.instances->tile_begin.data(), tiles, buckets.data());
  bucket_begin_.resize(tiles + 1);
  exclusive_sums(stream_, buckets.span(), bucket_begin_.span(), sort_scratch_);
  // every tile's last bucket may be incomplete: no more than this, whatever the lists are
  checkpoints_.resize((args.instances->count / kSegment + tiles) * kTilePixels);
}

/// With few tiles, lanes of one pixel and lists cut into segments keep the device busy; with many,
/// lanes of two do less work in all.
bool CudaBackend::is_small(const ViewBatch<float>& batch) const {
  constexpr int64_t kTilesPerProcessor = 48;
  return batch.tiles < kTilesPerProcessor * processors_;
}

void CudaBackend::blend(const BlendArgs<float>& args, Images<float>& images) {
  const KernelSwitches& switches = args.options.kernels;
  images.colour.resize(3 * args.batch->pixels);
  images.transmittance.resize(args.batch->pixels);
  images.used.resize(args.batch->pixels);
  const bool small = is_small(*args.batch);
  has_checkpoints_ = args.for_backward && !switches.deterministic && small &&
                     switches.backward == BackwardForm::kSubTile;
  if (has_checkpoints_) reserve_checkpoints(args);
  Blend a{views_of(*args.batch),
          int(args.batch->views.size()),
          args.instances->tile_begin.data(),
          args.instances->splat.data(),
          args.instances->tile_order.data(),
          args.splats->splat.data(),
          make_cutoff<float>(args.options),
          {},
          images.colour.data(),
          images.transmittance.data(),
          images.used.data(),
          checkpoints_.data(),
          bucket_begin_.data()};
  for (int c = 0; c < 3; ++c) a.background[c] = float(args.options.background[c]);
  const auto launch = [&](auto pixels, auto cull, auto checkpoint) {
    constexpr int kPixels = decltype(pixels)::value;
    blend_tiles<kPixels, decltype(cull)::value, decltype(checkpoint)::value>
        <<<grid_of(args.batch->tiles, 1), TileParts<kPixels>::kThreads, 0, stream_>>>(a);
  };
  using One = std::integral_constant<int, 1>;
  using Two = std::integral_constant<int, 2>;
  const auto by_cull = [&](auto pixels, auto checkpoint) {
    switches.warp_culling ? launch(pixels, std::true_type(), checkpoint)
                          : launch(pixels, std::false_type(), checkpoint);
  };
  const auto by_size = [&](auto checkpoint) {
    small ? by_cull(One(), checkpoint) : by_cull(Two(), checkpoint);
  };
  has_checkpoints_ ? by_size(std::true_type()) : by_size(std::false_type());
  check_launch("blend: blend_tiles");
  const double checkpointed = has_checkpoints_ ? 16.0 * kTilePixels / kSegment : 0.0;
  clock_.add_bytes(kBlend, double(args.instances->count) * (4 + 48 + checkpointed) +
                               20.0 * double(args.batch->pixels));
}

}  // namespace tessera
