// L1 + D-SSIM of a batch of views on a CUDA device, and its gradient, in one launch per pass. A
// block has a strip of one colour plane and goes down it in chunks of rows. A thread convolves one
// column of a chunk in registers, from global memory; the rows follow from shared memory, four
// pixels a thread. Pass 1 computes sums and the three weighted partial maps, pass 2 computes dL/dx
// from the maps. Each block writes its sums, and a small kernel adds them in a fixed order. Source:
// method A.15.
#include "kernels/cuda/photometric_tile.cuh"
#include "kernels/math/photometric.h"

namespace tessera {

using namespace photometric;

namespace {

/// Where things lie in scratch. Rows of a map are padded to 4 floats, so that they take float4.
struct ScratchLayout {
  int64_t view_gap;      // floats of a map's channel between views, for the padding of rows
  int64_t map_floats;    // of one map
  int64_t blocks;        // of a launch
  int tiles_x, tiles_y;  // of the largest view

  ScratchLayout(int64_t pixels, int view_count, int max_width, int max_height)
      : view_gap(round_up_to_4(3 * int64_t(max_height)) + 4),
        map_floats(3 * (round_up_to_4(pixels) + view_count * view_gap)),
        tiles_x((max_width + kTileWidth - 1) / kTileWidth),
        tiles_y((max_height + kTileHeight - 1) / kTileHeight) {
    blocks = int64_t(3) * tiles_x * tiles_y * view_count;
  }
  explicit ScratchLayout(const PhotometricLaunch& a)
      : ScratchLayout(a.pixels, a.view_count, a.max_width, a.max_height) {}

  size_t bytes(bool for_backward) const {
    return size_t(blocks) * sizeof(double2) +
           (for_backward ? size_t(kMaps * map_floats) * sizeof(float) : 0);
  }
};

__device__ inline int64_t index_of_block() {
  return (int64_t(blockIdx.z) * gridDim.y + blockIdx.y) * gridDim.x + blockIdx.x;
}

/// Pass 1: sums of |x − y| and SSIM, and with `Backward` the three maps. Of an ignored pixel the
/// truth is what was rendered, SSIM 1 and the maps 0.
template <bool Backward, bool Masked>
__global__ void __launch_bounds__(kThreads, 7) photometric_forward(KernelArgs args) {
  __shared__ __align__(16) Lines<kMoments, kForwardRows> lines;
  const Block block(args);
  if (block.outside()) {
    if (threadIdx.x == 0) args.block_sums[index_of_block()] = double2{0, 0};
    return;
  }
  const int column = block.column(), group = int(threadIdx.x % 32);
  const int nearest = block.nearest_column(column);
  const bool of_tile =
      int(threadIdx.x) >= kSsimRadius && int(threadIdx.x) < kSsimRadius + kTileWidth;
  const float lambda = -args.call.dssim_weight * block.scale;
  float l1 = 0, ssim = 0;
  for (int y = block.y0; y < min(block.y0 + kTileHeight, block.height); y += kForwardRows) {
    convolve_column<kMoments, kForwardRows>(lines, [&](int r, float(&value)[kMoments]) {
      const int row = y - kSsimRadius + r, p = block.nearest_row(row) * block.width + nearest;
      const float x = __ldg(block.colour + p);
      const float t = block.counts<Masked>(p) ? truth_value(__ldg(block.truth + 3 * p)) : x;
      const bool inside = block.contains(row, column);
      const float a = inside ? x : 0.0f, b = inside ? t : 0.0f;
      value[0] = a;
      value[1] = b;
      value[2] = a * a + b * b;
      value[3] = a * b;
      if (r >= kSsimRadius && r < kSsimRadius + kForwardRows)
        l1 += of_tile ? block.l1_factor<Masked>(p) * fabsf(a - b) : 0.0f;
    });
    __syncthreads();
    const int x = block.x0 + 4 * group;
#pragma unroll 1
    for (int row = int(threadIdx.x / 32); row < kForwardRows; row += kWarps) {
      if (group >= kTileWidth / 4 || x >= block.width || y + row >= block.height) break;
      float m[kMoments][4], map[kMaps][4];
      convolve_row<kMoments, kForwardRows>(lines, row, group, m);
#pragma unroll
      for (int j = 0; j < 4; ++j) {
        const SsimPoint<float> point =
            ssim_point<float>({m[0][j], m[1][j], m[2][j], m[3][j]}, args.call.c2);
        const bool inside = x + j < block.width;
        const bool counts = !inside || block.counts<Masked>((y + row) * block.width + x + j);
        if (inside) ssim += counts ? point.value : 1.0f;
        map[0][j] = counts ? lambda * point.d_x : 0.0f;
        map[1][j] = counts ? lambda * point.d_xx : 0.0f;
        map[2][j] = counts ? lambda * point.d_xy : 0.0f;
      }
      if constexpr (Backward) {
        float* const to = args.maps + block.map + int64_t(y + row) * block.pitch + x;
#pragma unroll
        for (int i = 0; i < kMaps; ++i)
          __stcg(reinterpret_cast<float4*>(to + i * args.map_floats),
                 make_float4(map[i][0], map[i][1], map[i][2], map[i][3]));
      }
    }
    __syncthreads();
  }
  const double2 sum = sum_of_block(double2{double(l1), double(ssim)});
  if (threadIdx.x == 0) args.block_sums[index_of_block()] = sum;
}

/// Pass 2: dL/dx = l1·sign(x − y) + g∗P + 2x·g∗Q + y·g∗U, for the maps P, Q, U with λ in them;
/// of an ignored pixel 0.
template <bool Masked>
__global__ void __launch_bounds__(kThreads, 8) photometric_backward(KernelArgs args) {
  __shared__ __align__(16) Lines<kMaps, kBackwardRows> lines;
  const Block block(args);
  if (block.outside()) return;
  const int column = block.column(), group = int(threadIdx.x % 32);
  const int nearest = block.nearest_column(column);
  const float* const maps = args.maps + block.map;
  const float l1 = args.call.l1_weight * block.scale;
  float* const d_colour = args.call.d_colour + block.plane;
  const bool aligned = block.width % 4 == 0 &&
                       reinterpret_cast<uintptr_t>(block.colour) % 16 == 0 &&
                       reinterpret_cast<uintptr_t>(d_colour) % 16 == 0;
  for (int y = block.y0; y < min(block.y0 + kTileHeight, block.height); y += kBackwardRows) {
    convolve_column<kMaps, kBackwardRows>(lines, [&](int r, float(&value)[kMaps]) {
      const int row = y - kSsimRadius + r;
      const float* const from = maps + (block.nearest_row(row) * block.pitch + nearest);
      const bool inside = block.contains(row, column);
#pragma unroll
      for (int i = 0; i < kMaps; ++i) {
        const float partial = __ldg(from + i * args.map_floats);
        value[i] = inside ? partial : 0.0f;
      }
    });
    __syncthreads();
    const int x = block.x0 + 4 * group;
#pragma unroll 1
    for (int row = int(threadIdx.x / 32); row < kBackwardRows; row += kWarps) {
      if (group >= kTileWidth / 4 || x >= block.width || y + row >= block.height) break;
      float m[kMaps][4], a[4], d[4];
      convolve_row<kMaps, kBackwardRows>(lines, row, group, m);
      const int p = (y + row) * block.width + x, count = min(4, block.width - x);
      if (aligned) {
        const float4 four = __ldg(reinterpret_cast<const float4*>(block.colour + p));
        a[0] = four.x;
        a[1] = four.y;
        a[2] = four.z;
        a[3] = four.w;
      } else {
        for (int j = 0; j < 4; ++j) a[j] = j < count ? block.colour[p + j] : 0.0f;
      }
#pragma unroll
      for (int j = 0; j < 4; ++j) {
        const float b = j < count ? truth_value(__ldg(block.truth + 3 * (p + j))) : 0.0f;
        const float weight = j < count ? l1 * block.l1_factor<Masked>(p + j) : l1;
        d[j] = photometric_gradient(weight, a[j], b, m[0][j], m[1][j], m[2][j]);
        if (j < count && !block.counts<Masked>(p + j)) d[j] = 0.0f;
      }
      if (aligned) {
        __stcg(reinterpret_cast<float4*>(d_colour + p), make_float4(d[0], d[1], d[2], d[3]));
      } else {
#pragma unroll
        for (int j = 0; j < 4; ++j)
          if (j < count) d_colour[p + j] = d[j];
      }
    }
    __syncthreads();
  }
}

/// sums[b] from the block sums of view b; one block a view.
__global__ void __launch_bounds__(kThreads) photometric_sums(KernelArgs args, int blocks_per_view) {
  const double2* const from = args.block_sums + int64_t(blockIdx.x) * blocks_per_view;
  double2 sum{0, 0};
  for (int i = int(threadIdx.x); i < blocks_per_view; i += kThreads) {
    sum.x += from[i].x;
    sum.y += from[i].y;
  }
  sum = sum_of_block(sum);
  if (threadIdx.x != 0) return;
  args.call.sums[2 * blockIdx.x] = sum.x;
  args.call.sums[2 * blockIdx.x + 1] = sum.y;
}

template <bool Masked>
void launch_passes(const KernelArgs& args, dim3 grid, cudaStream_t stream) {
  const unsigned views = unsigned(args.call.view_count);
  const int blocks_per_view = int(grid.x * grid.y);
  const bool backward = args.call.d_colour != nullptr;
  if (backward)
    photometric_forward<true, Masked><<<grid, kThreads, 0, stream>>>(args);
  else
    photometric_forward<false, Masked><<<grid, kThreads, 0, stream>>>(args);
  photometric_sums<<<views, kThreads, 0, stream>>>(args, blocks_per_view);
  if (!backward) return;
  photometric_backward<Masked><<<grid, kThreads, 0, stream>>>(args);
}

}  // namespace

size_t photometric_scratch_bytes(int64_t pixels, int view_count, int max_width, int max_height,
                                 bool for_backward) {
  return ScratchLayout(pixels, view_count, max_width, max_height).bytes(for_backward);
}

void launch_photometric(const PhotometricLaunch& call, cudaStream_t stream) {
  const ScratchLayout layout(call);
  if (layout.blocks == 0) return;
  KernelArgs args{call, static_cast<double2*>(call.scratch), nullptr, layout.map_floats,
                  layout.view_gap};
  args.maps = reinterpret_cast<float*>(args.block_sums + layout.blocks);
  const dim3 grid(unsigned(3 * layout.tiles_x), unsigned(layout.tiles_y),
                  unsigned(call.view_count));
  call.mask == nullptr ? launch_passes<false>(args, grid, stream)
                       : launch_passes<true>(args, grid, stream);
}

}  // namespace tessera
