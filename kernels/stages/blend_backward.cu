// What: gradient of blending on the device, front to back from the scalar R = ⟨colour still to
// come, dL/dC⟩. Lanes are pixels; splats that miss a warp's part of the tile are skipped. The other
// form, lanes as splats, is in blend_backward_per_gaussian.cu.
// Not: atomics when a fixed order is asked for: every warp then keeps its sum of each instance.
// Source: method A.11, C.3, G.4.
#include "kernels/base/errors.h"
#include "kernels/cuda/blend_backward_args.cuh"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"

namespace tessera {
namespace {

/// Sums the first eight values over a warp: lane l ends with the total of value l / 4.
__device__ inline float reduce_eight(const float (&v)[kGradientTerms]) {
  const int lane = int(threadIdx.x) % 32;
  const bool upper16 = lane & 16, upper8 = lane & 8, upper4 = lane & 4;
  float w[4];
  TESSERA_UNROLL
  for (int k = 0; k < 4; ++k) {
    const float mine = upper16 ? v[k + 4] : v[k], theirs = upper16 ? v[k] : v[k + 4];
    w[k] = mine + __shfl_xor_sync(~0u, theirs, 16);
  }
  float u[2];
  TESSERA_UNROLL
  for (int k = 0; k < 2; ++k) {
    const float mine = upper8 ? w[k + 2] : w[k], theirs = upper8 ? w[k] : w[k + 2];
    u[k] = mine + __shfl_xor_sync(~0u, theirs, 8);
  }
  const float mine = upper4 ? u[1] : u[0], theirs = upper4 ? u[0] : u[1];
  float sum = mine + __shfl_xor_sync(~0u, theirs, 4);
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
template <int Pixels>
__device__ inline bool step_lane(const SharedSplat& s, const Cutoff<float>& cutoff, int32_t index,
                                 PixelBackward (&pixel)[Pixels], float (&v)[kGradientTerms]) {
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
  for (int k = 0; k < kGradientTerms; ++k) v[k] = 0.0f;
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
  __device__ PixelBackward pixel(const BlendBackward& a, const TilePixel& at) const {
    if constexpr (Segmented)
      return {a, at, a.checkpoints[bucket * kTilePixels + at.number]};
    else
      return {a, at, {0, 0, 0, 1}};
  }
};

template <int Pixels, bool Cull, bool Ordered, bool Segmented>
__global__ void __launch_bounds__(TileParts<Pixels>::kThreads) backward_tiles(BlendBackward a) {
  __shared__ SharedSplat shared[TileParts<Pixels>::kWarps][kBucket];
  const Work<Segmented> work(a);
  if (work.none) return;
  const int64_t first = a.tile_begin[work.tile];
  const BatchTile at(a.views, a.view_count, work.tile);
  const WarpPart<Pixels> part(at);
  const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
  PixelBackward pixel[Pixels];
  int32_t last = 0;
  TESSERA_UNROLL
  for (int p = 0; p < Pixels; ++p) {
    pixel[p] = work.pixel(a, part.pixel(p));
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
      float v[kGradientTerms];
      if (!step_lane(splats[i], a.cutoff, splats.begin() + i, pixel, v)) continue;
      // lanes 0, 4, … 28 get the first eight terms, lane 1 the ninth
      const float sum = reduce_eight(v), ninth = reduce_one(v[8]);
      const int term = lane == 1 ? 8 : lane / 4;
      if (lane % 4 != 0 && lane != 1) continue;
      const float value = (lane == 1 ? ninth : sum) * gradient_scale(term);
      if constexpr (Ordered)
        reinterpret_cast<float*>(a.d_instances + warp * a.instances + first + splats.begin() +
                                 i)[term] = value;
      else
        atomicAdd(reinterpret_cast<float*>(a.d_splats + number) + term, value);
    }
  }
}

/// Gradients of a splat's instances, added in the order in which it was written into tiles, and of
/// each by the parts of the tile.
__global__ void add_instances(const SplatGradient<float>* d_instances, int64_t instances, int parts,
                              const int64_t* first_of, const int32_t* tiles, const int64_t* slot,
                              int64_t count, float* d_splats) {
  const int64_t at = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  const int64_t s = at / kGradientTerms;
  if (s >= count) return;
  float sum = 0;
  for (int k = 0; k < tiles[s]; ++k)
    for (int part = 0; part < parts; ++part)
      sum += reinterpret_cast<const float*>(d_instances + part * instances +
                                            slot[first_of[s] + k])[at % kGradientTerms];
  d_splats[at] = sum;
}

template <int Pixels, bool Cull, bool Ordered, bool Segmented>
void launch(const BlendBackward& a, int64_t blocks, cudaStream_t stream) {
  backward_tiles<Pixels, Cull, Ordered, Segmented>
      <<<grid_of(blocks, 1), TileParts<Pixels>::kThreads, 0, stream>>>(a);
}

}  // namespace

void CudaBackend::blend_backward(const BlendBackwardArgs<float>& args,
                                 Span<SplatGradient<float>> d_splats) {
  const TileInstances<float>& instances = *args.forward.instances;
  const KernelSwitches& switches = args.forward.options.kernels;
  BlendBackward a{views_of(*args.forward.batch),
                  int(args.forward.batch->views.size()),
                  instances.tile_begin.data(),
                  instances.splat.data(),
                  instances.tile_order.data(),
                  instances.count,
                  args.forward.splats->splat.data(),
                  make_cutoff<float>(args.forward.options),
                  args.images->colour.data(),
                  args.d_colour.data,
                  args.images->used.data(),
                  d_splats.data,
                  nullptr,
                  checkpoints_.data(),
                  bucket_begin_.data(),
                  args.forward.batch->tiles};
  const auto clear = [&](Span<SplatGradient<float>> gradients) {
    if (!gradients.empty())
      check_device(cudaMemsetAsync(gradients.data, 0,
                                   size_t(gradients.size) * sizeof(SplatGradient<float>), stream_),
                   "memset");
  };
  clear(d_splats);
  const int64_t tiles = args.forward.batch->tiles;
  const bool cull = switches.backward != BackwardForm::kPixel;
  if (switches.deterministic) {
    constexpr int kParts = TileParts<2>::kWarps;
    instance_gradients_.resize(kParts * instances.count);
    clear(instance_gradients_.span());
    a.d_instances = instance_gradients_.data();
    cull ? launch<2, true, true, false>(a, tiles, stream_)
         : launch<2, false, true, false>(a, tiles, stream_);
    add_instances<<<grid_of(d_splats.size * kGradientTerms, 256), 256, 0, stream_>>>(
        instance_gradients_.data(), instances.count, kParts, instances.first_of.data(),
        args.forward.splats->tiles.data(), instances.slot.data(), d_splats.size,
        reinterpret_cast<float*>(d_splats.data));
  } else if (switches.backward == BackwardForm::kPerGaussian) {
    launch_per_gaussian(a, instances.count, stream_);
  } else if (checkpoint_interval_ == kSegment) {
    launch<1, true, false, true>(a, instances.count / kSegment + tiles, stream_);
  } else {
    cull ? launch<2, true, false, false>(a, tiles, stream_)
         : launch<2, false, false, false>(a, tiles, stream_);
  }
  check_launch("blend_backward");
  clock_.add_bytes(kBlendBackward, double(instances.count) * (4 + 48 + 36) +
                                       36.0 * 2 * double(d_splats.size) +
                                       28.0 * double(args.forward.batch->pixels));
}

}  // namespace tessera
