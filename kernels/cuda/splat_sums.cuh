// What: sums over the pixels of every splat on the device, front to back through each tile: the
// walk that the gradient of blending and the sensitivity share. Lanes are pixels; splats that miss
// a warp's part of the tile are skipped. Not: atomics when a fixed order is asked for: every warp
// then keeps its sum of each instance. Not what is summed: a Pixel says that. Source: method A.11,
// G.4.
#pragma once
#include "kernels/cuda/blend_backward_args.cuh"
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/launch.cuh"

namespace tessera {

/// Sums the first eight values over a warp (0 where there are fewer): lane l ends with the total of
/// value l / 4.
template <int Terms>
__device__ inline float reduce_eight(const float (&v)[Terms]) {
  const int lane = int(threadIdx.x) % 32;
  static_assert(Terms >= 4);
  const bool upper16 = lane & 16, upper8 = lane & 8, upper4 = lane & 4;
  float w[4];
  TESSERA_UNROLL
  for (int k = 0; k < 4; ++k) {
    const float upper = k + 4 < Terms ? v[k + 4] : 0.0f;
    const float kept = upper16 ? upper : v[k], sent = upper16 ? v[k] : upper;
    w[k] = kept + __shfl_xor_sync(~0u, sent, 16);
  }
  float u[2];
  TESSERA_UNROLL
  for (int k = 0; k < 2; ++k) {
    const float kept = upper8 ? w[k + 2] : w[k], sent = upper8 ? w[k] : w[k + 2];
    u[k] = kept + __shfl_xor_sync(~0u, sent, 8);
  }
  const float kept = upper4 ? u[1] : u[0], sent = upper4 ? u[0] : u[1];
  float sum = kept + __shfl_xor_sync(~0u, sent, 4);
  sum += __shfl_xor_sync(~0u, sum, 2);
  return sum + __shfl_xor_sync(~0u, sum, 1);
}

__device__ inline float reduce_one(float v) {
  TESSERA_UNROLL
  for (int step = 16; step > 0; step /= 2) v += __shfl_xor_sync(~0u, v, step);
  return v;
}

/// In every lane.
__device__ inline int32_t largest_of_warp(int32_t v) {
  TESSERA_UNROLL
  for (int step = 16; step > 0; step /= 2) v = max(v, __shfl_xor_sync(~0u, v, step));
  return v;
}

/// A lane's pixels take their step past a splat; false for the whole warp when none draws it.
template <class Pixel, int Pixels>
__device__ inline bool step_lane(const SharedSplat& s, const Cutoff<float>& cutoff, int32_t index,
                                 Pixel (&pixel)[Pixels], float (&v)[Pixel::kTerms]) {
  bool on[Pixels], any = false;
  PixelResponse response[Pixels];
  TESSERA_UNROLL
  for (int p = 0; p < Pixels; ++p) {
    response[p] = PixelResponse(s, pixel[p].x, pixel[p].y);
    on[p] = cutoff.draws(response[p].alpha, response[p].falloff) && index < pixel[p].used;
    any = any || on[p];
  }
  if (!__any_sync(~0u, any)) return false;
  TESSERA_UNROLL
  for (int k = 0; k < Pixel::kTerms; ++k) v[k] = 0.0f;
  TESSERA_UNROLL
  for (int p = 0; p < Pixels; ++p) pixel[p].step(s, response[p], on[p], v);
  return true;
}

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
///   Args, kTerms: what it is made from (a BlendBackward), how many floats it sums
///   x, y, used: its centre, and how many splats of the tile it goes past
///   step(splat, response, on, v): its step past a splat, its share added to v
///   scale(term): what a sum of v[term] still has to be multiplied with.
template <class Pixel, int Pixels, bool Cull, bool Ordered, bool Segmented>
__global__ void __launch_bounds__(TileParts<Pixels>::kThreads) sum_tiles(typename Pixel::Args a) {
  __shared__ SharedSplat shared[TileParts<Pixels>::kWarps][kBucket];
  const Work<Segmented> work(a);
  if (work.none) return;
  const int64_t first = a.tile_begin[work.tile];
  const BatchTile batch_tile(a.views, a.view_count, work.tile);
  const WarpPart<Pixels> part(batch_tile);
  const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
  Pixel pixel[Pixels];
  int32_t last = 0;
  TESSERA_UNROLL
  for (int p = 0; p < Pixels; ++p) {
    pixel[p] = work.template pixel<Pixel>(a, part.pixel(p));
    last = max(last, pixel[p].used);
  }
  last = largest_of_warp(last);
  if (Segmented) last = min(last, work.begin + kSegment);
  WarpSplats splats(a.splats, a.instance + first, work.begin, last, shared[warp]);
  while (!splats.done()) {
    unsigned hits = splats.next_bucket<Cull>(part);
    for (; hits != 0; hits &= hits - 1) {
      const int i = __ffs(int(hits)) - 1;
      const int32_t number = splats.number(i);
      float v[Pixel::kTerms];
      if (!step_lane(splats[i], a.cutoff, splats.begin() + i, pixel, v)) continue;
      // lanes 0, 4, … 28 get the first eight terms, lane 1 the ninth
      float value = reduce_eight(v);
      int term = lane % 4 == 0 ? lane / 4 : Pixel::kTerms;
      if constexpr (Pixel::kTerms > 8) {
        const float ninth = reduce_one(v[8]);
        if (lane == 1) {
          value = ninth;
          term = 8;
        }
      }
      if (term >= Pixel::kTerms) continue;
      value *= Pixel::scale(term);
      if constexpr (Ordered)
        a.instance_sums[(warp * a.instances + first + splats.begin() + i) * Pixel::kTerms + term] =
            value;
      else
        atomicAdd(a.sums + int64_t(number) * Pixel::kTerms + term, value);
    }
  }
}

/// Sums of a splat's instances, added in the order in which it was written into tiles, and of each
/// by the parts of the tile.
template <int Terms>
__global__ void add_instances(const float* instance_sums, int64_t instances, int parts,
                              const int64_t* first_of, const int32_t* tiles, const int64_t* slot,
                              int64_t count, float* sums) {
  const int64_t i = linear_index();
  const int64_t s = i / Terms;
  if (s >= count) return;
  float sum = 0;
  for (int k = 0; k < tiles[s]; ++k)
    for (int part = 0; part < parts; ++part)
      sum += instance_sums[(part * instances + slot[first_of[s] + k]) * Terms + i % Terms];
  sums[i] = sum;
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
  launch_linear<256>(stream, "add_instances", add_instances<Pixel::kTerms>, splats * Pixel::kTerms,
                     a.instance_sums, a.instances, kParts, instances.first_of.data(),
                     forward.splats->tiles.data(), instances.slot.data(), splats, a.sums);
}

}  // namespace tessera
