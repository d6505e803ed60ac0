// Arguments and parts of the photometric kernels (L1 + D-SSIM and its gradient): the tile of a
// colour plane that a block works on, the SSIM window along columns (in registers) and along rows
// (from shared memory), and the sum over a block. Source: method A.15; the numbers equal those of
// stages/photometric.cpp up to rounding.
#pragma once
#include <cuda_runtime.h>
#include <cstddef>
#include <cstdint>
#include "kernels/math/ewa.h"
#include "kernels/math/photometric.h"

namespace tessera {

struct PhotometricLaunch {
  const ViewArgs<float>* views;  // [B] device
  const uint8_t* const* truth;   // [B] device, each [height, width, 3]
  const uint8_t* const* mask;    // [B] device, each [height, width] or null; null: no view has one
  int view_count;                // B
  int max_width, max_height;     // largest of the batch, pixels
  int64_t pixels;                // of all views
  const float* colour;  // [3·pixels] channel c of view b at 3·first_pixel + c·width·height
  float* d_colour;      // same layout, written; nullptr: only the loss is wanted
  void* scratch;        // device, photometric_scratch_bytes(...), from cudaMalloc
  double* sums;         // [B, 2] device: Σ|I−G|, Σ SSIM over 3·H·W; written, not added to
  float l1_weight, dssim_weight;
  float moving_weight;  // factor of |I−G| where the mask is kMovingPixel
  float c2;             // LossWeights::c2
};

size_t photometric_scratch_bytes(int64_t pixels, int view_count, int max_width, int max_height,
                                 bool for_backward);

/// Asynchronous; errors are left to cudaGetLastError. Equal inputs give equal bits.
void launch_photometric(const PhotometricLaunch& args, cudaStream_t stream);

}  // namespace tessera

namespace tessera::photometric {

constexpr int kThreads = 128;      // a block; a thread has one column, halo included
constexpr int kTileWidth = 116;    // pixels; the largest multiple of 4 that leaves a halo
constexpr int kTileHeight = 32;    // pixels
constexpr int kForwardRows = 16;   // of a chunk of pass 1
constexpr int kBackwardRows = 16;  // of a chunk of pass 2
constexpr int kWarps = kThreads / 32;
constexpr int kMoments = 4;  // of pass 1
constexpr int kMaps = 3;     // λ·∂SSIM by E[x], E[x²], E[x·y]
static_assert(kTileWidth % 4 == 0 && kTileWidth + 2 * kSsimRadius <= kThreads);
static_assert(kTileHeight % kForwardRows == 0 && kTileHeight % kBackwardRows == 0);

/// Planes of a chunk after the convolution along columns.
template <int Planes, int Rows>
using Lines = float[Planes][Rows][kThreads];

struct Taps {
  float tap[kSsimTaps];
};
constexpr Taps ssim_taps() {
  Taps taps{};
  for (int k = 0; k < kSsimTaps; ++k) taps.tap[k] = kSsimWindow<float>[k];
  return taps;
}

__host__ __device__ constexpr int64_t round_up_to_4(int64_t i) {
  return (i + 3) / 4 * 4;
}

/// What a kernel gets: the call, and scratch by its parts.
struct KernelArgs {
  PhotometricLaunch call;
  double2* block_sums;  // [view, tile_y, tile_x, channel]
  float* maps;          // [kMaps][map_floats]
  int64_t map_floats, view_gap;
};

/// The colour plane and the tile of this block.
struct Block {
  int width, height, pitch;  // of the plane; floats between rows of a map
  int x0, y0;                // first pixel of the tile
  const float* colour;       // [height, width]
  const uint8_t* truth;      // sample of pixel p at 3·p
  const uint8_t* mask;       // [height, width], 0: ignored; null: all pixels count
  int64_t plane, map;        // first element in colour and d_colour, in a map
  float scale;               // 1 / (3·H·W·B)
  float moving;              // factor of |x − y| where something moves

  __device__ explicit Block(const KernelArgs& args) {
    const int channel = int(blockIdx.x % 3), b = int(blockIdx.z);
    const ViewArgs<float>& view = args.call.views[b];
    width = view.width;
    height = view.height;
    pitch = int(round_up_to_4(width));
    x0 = int(blockIdx.x / 3) * kTileWidth;
    y0 = int(blockIdx.y) * kTileHeight;
    const int64_t first = view.first_pixel, pixels = int64_t(width) * height;
    plane = 3 * first + channel * pixels;
    map = 3 * (round_up_to_4(first) + b * args.view_gap) + channel * int64_t(pitch) * height;
    colour = args.call.colour + plane;
    truth = args.call.truth[b] + channel;
    mask = args.call.mask == nullptr ? nullptr : args.call.mask[b];
    moving = args.call.moving_weight;
    scale = 1.0f / (3.0f * float(pixels) * float(args.call.view_count));
  }
  __device__ bool outside() const { return x0 >= width || y0 >= height; }
  /// The column of this thread, halo included.
  __device__ int column() const { return x0 - kSsimRadius + int(threadIdx.x); }
  __device__ bool contains(int row, int column) const {
    return row >= 0 && row < height && column >= 0 && column < width;
  }
  /// Whether pixel p adds to the loss; kernels without masks do not test it.
  template <bool Masked>
  __device__ bool counts(int p) const {
    if constexpr (Masked)
      return mask == nullptr || __ldg(mask + p) != 0;
    else
      return true;
  }
  /// Factor of the L1 term of pixel p.
  template <bool Masked>
  __device__ float l1_factor(int p) const {
    if constexpr (Masked)
      return mask != nullptr && __ldg(mask + p) == kMovingPixel ? moving : 1.0f;
    else
      return 1.0f;
  }
  /// The nearest pixel: loads need no branch, what lies outside is set to zero afterwards.
  __device__ int nearest_row(int row) const { return min(max(row, 0), height - 1); }
  __device__ int nearest_column(int column) const { return min(max(column, 0), width - 1); }
};

/// byte / 255, correctly rounded as the host divides: one step of Newton from b·(1/255).
__device__ inline float truth_value(uint8_t byte) {
  constexpr float kInverse = 1.0f / 255.0f;
  const float b = float(byte), q = b * kInverse;
  return fmaf(fmaf(-q, 255.0f, b), kInverse, q);
}

/// Along the column of this thread: sample(r, value) gives row r − kSsimRadius of the chunk.
template <int Planes, int Rows, class Sample>
__device__ inline void convolve_column(Lines<Planes, Rows>& lines, Sample&& sample) {
  constexpr Taps kTaps = ssim_taps();
  float sum[Planes][Rows];
#pragma unroll
  for (int r = 0; r < Rows + 2 * kSsimRadius; ++r) {
    float value[Planes];
    sample(r, value);
#pragma unroll
    for (int row = 0; row < Rows; ++row) {
      const int k = r - row;
      if (k < 0 || k >= kSsimTaps) continue;
#pragma unroll
      for (int i = 0; i < Planes; ++i) {
        const float before = k == 0 ? 0.0f : sum[i][row];
        sum[i][row] = k == 0 ? kTaps.tap[k] * value[i] : fmaf(kTaps.tap[k], value[i], before);
        if (k == kSsimTaps - 1) lines[i][row][threadIdx.x] = sum[i][row];
      }
    }
  }
}

/// Along a row of the chunk: pixels 4·group … 4·group + 3 of the tile.
template <int Planes, int Rows>
__device__ inline void convolve_row(const Lines<Planes, Rows>& lines, int row, int group,
                                    float (&out)[Planes][4]) {
  constexpr Taps kTaps = ssim_taps();
#pragma unroll
  for (int i = 0; i < Planes; ++i) {
    const float4* from = reinterpret_cast<const float4*>(&lines[i][row][0]) + group;
    float value[16];
#pragma unroll
    for (int q = 0; q < 4; ++q) {
      const float4 four = from[q];
      value[4 * q] = four.x;
      value[4 * q + 1] = four.y;
      value[4 * q + 2] = four.z;
      value[4 * q + 3] = four.w;
    }
#pragma unroll
    for (int j = 0; j < 4; ++j) {
      out[i][j] = kTaps.tap[0] * value[j];
#pragma unroll
      for (int k = 1; k < kSsimTaps; ++k) out[i][j] = fmaf(kTaps.tap[k], value[j + k], out[i][j]);
    }
  }
}

/// Sum over the threads of a block, in a fixed order; valid in thread 0.
__device__ inline double2 sum_of_block(double2 sum) {
  __shared__ double2 warps[kWarps];
#pragma unroll
  for (int offset = 16; offset > 0; offset /= 2) {
    sum.x += __shfl_down_sync(0xffffffffu, sum.x, offset);
    sum.y += __shfl_down_sync(0xffffffffu, sum.y, offset);
  }
  if (threadIdx.x % 32 == 0) warps[threadIdx.x / 32] = sum;
  __syncthreads();
  sum = warps[0];
#pragma unroll
  for (int w = 1; w < kWarps; ++w) {
    sum.x += warps[w].x;
    sum.y += warps[w].y;
  }
  return sum;
}

}  // namespace tessera::photometric
