// Sums over the pixels of every splat on the device, front to back through each tile. The gradient
// of blending and the sensitivity share this traversal; the type Pixel defines the summands. Lanes
// are pixels; splats that miss a warp's part of the tile are skipped. Atomics add the sums, except
// in deterministic mode, where every warp keeps its sum of each instance. Source: method A.11, G.4.
#pragma once
#include "kernels/cuda/blend_backward_args.cuh"
#include "kernels/cuda/launch.cuh"

namespace tessera {

/// What a block works on: a tile's whole list, or a segment of it behind a checkpoint.
template <bool Segmented>
struct Work {
  int64_t tile = 0, bucket = 0;
  int32_t begin = 0;
  bool none = false;

  __device__ explicit Work(const BlendBackward& a) {
    if constexpr (Segmented) {
      bucket = blockIdx.x;
      none = bucket >= a.bucket_begin[a.tiles];
      if (none) return;
      tile = a.tile_of_bucket(bucket);
      begin = int32_t(bucket - a.bucket_begin[tile]) * kSegment;
    } else {
      tile = a.tile_order[blockIdx.x];
      none = a.tile_begin[tile] == a.tile_begin[tile + 1];
    }
  }
  template <class Pixel>
  __device__ Pixel pixel(const typename Pixel::Args& a, const TilePixel& tile_pixel) const {
    if constexpr (Segmented)
      return {a, tile_pixel, a.checkpoints[bucket * kTilePixels + tile_pixel.number]};
    else
      return {a, tile_pixel, {0, 0, 0, 1}};
  }
};

/// Sums of every splat. A Pixel has
///   Args: what it is made from (a BlendBackward)
///   kLaneTerms, kTerms: floats that a lane sums over its column, and that a splat gets
///   x, y, used: its centre, and how many splats of the tile it goes past
///   step(splat, response, on, add): its step past a splat, add(k, its share of lane term k)
///   combine(a, b): of two shares of a lane term
///   reduce(dx, v): of what the lanes of a warp summed, the total of the term that is this lane's
///   term_of_lane(): which that is; kTerms: none
///   give(args, to, splat, total): adds such a total; `to`: the term of the first splat
///   sum(args, splat, term): where such a sum lies.
template <class Pixel, int Pixels, bool Cull, bool Ordered, bool Segmented>
__global__ void __launch_bounds__(TileParts<Pixels>::kThreads) sum_tiles(typename Pixel::Args a) {
  __shared__ SharedSplat shared[TileParts<Pixels>::kWarps][kBucket];
  const Work<Segmented> work(a);
  if (work.none) return;
  const int64_t first = a.tile_begin[work.tile];
  const BatchTile batch_tile(a.views, a.view_count, work.tile);
  const WarpPart<Pixels> part(batch_tile);
  const int warp = int(threadIdx.x) / 32, term = Pixel::term_of_lane();
  float* const to = a.sums + term;
  Pixel pixel[Pixels];
  int32_t last = 0;
  TESSERA_UNROLL
  for (int p = 0; p < Pixels; ++p) {
    pixel[p] = work.template pixel<Pixel>(a, part.pixel(p));
    last = max(last, pixel[p].used);
  }
  last = largest_of_warp(last);
  if (Segmented) last = min(last, work.begin + kSegment);
  WarpSplats splats(a.splats, a.cutoff, a.instance + first, work.begin, last, shared[warp]);
  while (!splats.done()) {
    unsigned hits = splats.next_bucket<Cull>(part);
    for (; hits != 0; hits &= hits - 1) {
      const int i = __ffs(int(hits)) - 1;
      const SharedSplat& splat = splats[i];
      const int32_t index = splats.begin() + i;
      const ColumnResponse column(splat, pixel[0].x);
      PixelResponse response[Pixels];
      bool on[Pixels], any = false;
      TESSERA_UNROLL
      for (int p = 0; p < Pixels; ++p) {
        response[p] = PixelResponse(splat, column, pixel[p].y);
        on[p] = response[p].drawn(splat) && index < pixel[p].used;
        any = any || on[p];
      }
      if (!__any_sync(~0u, any)) continue;
      float v[Pixel::kLaneTerms];
      TESSERA_UNROLL
      for (int p = 0; p < Pixels; ++p)
        pixel[p].step(splat, response[p], on[p], [&](int k, float term) {
          v[k] = p == 0 ? term : Pixel::combine(v[k], term);
        });
      const float sum = Pixel::reduce(column.dx, v);
      if (term >= Pixel::kTerms) continue;
      if constexpr (Ordered)
        a.instance_sums[(warp * a.instances + first + index) * Pixel::kTerms + term] = sum;
      else
        Pixel::give(a, to, splat.number(), sum);
    }
  }
}

/// Sums of a splat's instances, added in the order in which it was written into tiles, and of each
/// by the parts of the tile.
template <class Pixel>
__global__ void add_instances(typename Pixel::Args a, int parts, const int64_t* first_of,
                              const int32_t* tiles, const int64_t* slot, int64_t count) {
  constexpr int kTerms = Pixel::kTerms;
  const int64_t i = linear_index();
  const int64_t s = i / kTerms;
  if (s >= count) return;
  float sum = 0;
  for (int k = 0; k < tiles[s]; ++k)
    for (int part = 0; part < parts; ++part)
      sum += a.instance_sums[(part * a.instances + slot[first_of[s] + k]) * kTerms + i % kTerms];
  Pixel::sum(a, s, int(i % kTerms)) = sum;
}

template <class Pixel, int Pixels, bool Cull, bool Ordered, bool Segmented>
void launch_sums(const typename Pixel::Args& a, int64_t blocks, cudaStream_t stream) {
  sum_tiles<Pixel, Pixels, Cull, Ordered, Segmented>
      <<<grid_of(blocks, 1), TileParts<Pixels>::kThreads, 0, stream>>>(a);
}

inline void clear_sums(Span<float> sums, cudaStream_t stream) {
  if (!sums.empty())
    check_device(cudaMemsetAsync(sums.data, 0, size_t(sums.size) * sizeof(float), stream),
                 "memset");
}

/// In a fixed order; `instance_sums` is scratch that only grows.
template <class Pixel, bool Cull>
void launch_sums_in_order(typename Pixel::Args a, const BlendArgs<float>& forward,
                          Buffer<float>& instance_sums, cudaStream_t stream) {
  constexpr int kParts = TileParts<2>::kWarps;
  const TileInstances<float>& instances = *forward.instances;
  instance_sums.resize(kParts * Pixel::kTerms * instances.count);
  clear_sums(instance_sums.span(), stream);
  a.instance_sums = instance_sums.data();
  launch_sums<Pixel, 2, Cull, true, false>(a, a.tiles, stream);
  const int64_t splats = forward.splats->count;
  launch_linear<256>(stream, "add_instances", add_instances<Pixel>, splats * Pixel::kTerms, a,
                     kParts, instances.first_of.data(), forward.splats->tiles.data(),
                     instances.slot.data(), splats);
}

}  // namespace tessera
