// Colour maps applied to images on the device, one thread for each pixel, and the gradients by the
// rendered images and by the maps, which are summed in a fixed order. Source:
// kernels/math/colour_map.h.
#include <cstring>

#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"

namespace tessera {
namespace {

constexpr int kThreads = 256;
constexpr int kParts = 64;  // blocks of a view whose sums are added at the end
constexpr int kTerms = 12;  // doubles of a ColourMap<double>
static_assert(sizeof(ColourMap<double>) == kTerms * sizeof(double));

__global__ void __launch_bounds__(kThreads)
    write_mapped(const ViewArgs<float>* views, const ColourMap<float>* maps, const float* colour,
                 float* mapped) {
  const ViewArgs<float>& view = views[blockIdx.y];
  const int64_t pixels = int64_t(view.width) * view.height, first = 3 * view.first_pixel;
  const int64_t p = linear_index();
  if (p >= pixels) return;
  set_planar_colour(mapped + first, pixels, p,
                    maps[blockIdx.y](planar_colour(colour + first, pixels, p)));
}

/// Part blockIdx.x of view blockIdx.y takes every kParts-th run of pixels and writes its sums.
__global__ void __launch_bounds__(kThreads)
    take_back(const ViewArgs<float>* views, const ColourMap<float>* maps, const float* colour,
              float* d_colour, double* part_sums) {
  __shared__ double warps[kThreads / 32][kTerms];
  const ViewArgs<float>& view = views[blockIdx.y];
  const ColourMap<float> map = maps[blockIdx.y];
  const int64_t pixels = int64_t(view.width) * view.height, first = 3 * view.first_pixel;
  ColourMap<float> sum{Mat3<float>(0.0f), Vec3<float>(0.0f)};
  for (int64_t p = linear_index(); p < pixels; p += int64_t(kParts) * kThreads) {
    const Vec3<float> d_x = planar_colour(d_colour + first, pixels, p);
    sum += colour_map_gradient(planar_colour(colour + first, pixels, p), d_x);
    set_planar_colour(d_colour + first, pixels, p, through_colour_map(map, d_x));
  }
#pragma unroll
  for (int k = 0; k < kTerms; ++k) {
    double term = double(k < 9 ? sum.matrix[k / 3][k % 3] : sum.offset[k - 9]);
    for (int offset = 16; offset > 0; offset /= 2)
      term += __shfl_down_sync(0xffffffffu, term, offset);
    if (threadIdx.x % 32 == 0) warps[threadIdx.x / 32][k] = term;
  }
  __syncthreads();
  if (threadIdx.x >= kTerms) return;
  double term = 0;
  for (int w = 0; w < kThreads / 32; ++w) term += warps[w][threadIdx.x];
  part_sums[(int64_t(blockIdx.y) * kParts + blockIdx.x) * kTerms + threadIdx.x] = term;
}

/// A block a view, a thread a term.
__global__ void __launch_bounds__(kTerms)
    add_parts(const double* part_sums, ColourMap<double>* sums) {
  double term = 0;
  for (int part = 0; part < kParts; ++part)
    term += part_sums[(int64_t(blockIdx.x) * kParts + part) * kTerms + threadIdx.x];
  reinterpret_cast<double*>(sums + blockIdx.x)[threadIdx.x] = term;
}

}  // namespace

const ColourMap<float>* CudaBackend::maps_of(const ColourMapArgs<float>& args) {
  const auto count = int64_t(args.maps.size());
  std::vector<ColourMap<float>> maps;
  for (const ColourMap<double>& map : args.maps) maps.push_back(map.as<float>());
  const size_t bytes = sizeof(ColourMap<float>) * maps.size();
  if (maps_.size() == count && std::memcmp(maps_host_.data(), maps.data(), bytes) == 0)
    return maps_.data();
  check_device(cudaEventSynchronize(maps_copied_), "waiting for the last copy of maps");
  std::memcpy(maps_host_.reserve(count), maps.data(), bytes);
  maps_.resize(count);
  check_device(
      cudaMemcpyAsync(maps_.data(), maps_host_.data(), bytes, cudaMemcpyHostToDevice, stream_),
      "copy of maps of colours");
  check_device(cudaEventRecord(maps_copied_, stream_), "cudaEventRecord");
  return maps_.data();
}

void CudaBackend::map_colours(const ColourMapArgs<float>& args, Span<float> mapped) {
  check_target(args);
  if (args.batch->pixels == 0) return;
  write_mapped<<<grid_of_views(*args.batch, kThreads), kThreads, 0, stream_>>>(
      views_of(*args.batch), maps_of(args), args.colour.data, mapped.data);
  check_launch("map of colours");
  clock_.add_bytes(kPhotometric, 3.0 * double(args.batch->pixels) * (4 + 4));
}

void CudaBackend::map_colours_backward(const ColourMapArgs<float>& args, Span<float> d_colour) {
  check_target(args);
  const auto views = unsigned(args.maps.size());
  if (args.batch->pixels == 0) return;
  scratch_.resize(int64_t(views) * kParts * kTerms * int64_t(sizeof(double)));
  auto* const part_sums = reinterpret_cast<double*>(scratch_.data());
  map_sums_.resize(views);
  take_back<<<dim3(kParts, views), kThreads, 0, stream_>>>(
      views_of(*args.batch), maps_of(args), args.colour.data, d_colour.data, part_sums);
  add_parts<<<views, kTerms, 0, stream_>>>(part_sums, map_sums_.data());
  check_launch("gradient of maps of colours");
  report();
  clock_.add_bytes(kPhotometric, 3.0 * double(args.batch->pixels) * (4 + 4 + 4));
}

}  // namespace tessera
