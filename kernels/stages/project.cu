// What: Gaussians → splats of every view on the device. One thread owns a Gaussian and loops over
// the views: how many draw it, a scan, the splats at their places, their colours, their tiles.
// Not: equations (math/splat.h). Compiled without contraction to fused multiply-adds: the passes
// must decide alike, and so must the tile test here and in bin.cu.
// Source: method A.5–A.8; order of the splats without atomics: method 0.27.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/sh_registers.cuh"
#include "kernels/cuda/sort.h"
#include "kernels/cuda/tile_walk.cuh"
#include "kernels/math/splat.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;

/// What all passes need of a set; Gaussian n of it is number first + n of both sets.
struct SetArgs {
  GaussianSpans<const float> set;
  int64_t first;
  const ViewArgs<float>* views;
  int view_count;
  float near_plane, far_plane;
  BoundsOptions bounds;
  bool sliced_direction;
};

template <int Dim>
__global__ void __launch_bounds__(kThreads)
    count_views(SetArgs a, int32_t* visible, StepCounters* counters) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= a.set.count) return;
  GaussianState<float> g;
  int count = 0;
  if (!load_gaussian<Dim>(a.set, n, g)) {
    atomicAdd(&counters->invalid, 1u);
  } else {
    ViewSplat<float> splat;
    for (int b = 0; b < a.view_count; ++b)
      count += splat_in_view(a.views[b], g, a.near_plane, a.far_plane, a.bounds, splat);
  }
  visible[a.first + n] = count;
}

/// The splats at their places; the viewing direction stands where the colour will.
template <int Dim>
__global__ void __launch_bounds__(kThreads)
    write_views(SetArgs a, const int64_t* first_of, int64_t capacity, Splat<float>* splats,
                float* depth, TileRect* rects) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= a.set.count) return;
  int64_t s = first_of[a.first + n];
  const int64_t last = first_of[a.first + n + 1];
  GaussianState<float> g;
  if (s == last || last > capacity || !load_gaussian<Dim>(a.set, n, g)) return;
  for (int b = 0; b < a.view_count; ++b) {
    ViewSplat<float> splat;
    if (!splat_in_view(a.views[b], g, a.near_plane, a.far_plane, a.bounds, splat)) continue;
    Splat<float> out;
    float distance;
    out.colour = view_direction(a.views[b], a.sliced_direction ? splat.slice.mean : g.mean,
                                distance);
    out.mean2d = splat.projection.mean2d, out.conic = splat.projection.conic;
    out.opacity = splat.opacity, out.power = splat.power;
    out.view = b, out.negative = 0;
    splats[s] = out, depth[s] = splat.projection.in_cam[2], rects[s] = splat.rect;
    ++s;
  }
}

/// Direction → colour, for all splats of a Gaussian. One whose colour is not finite is not drawn.
__global__ void __launch_bounds__(kThreads)
    colour_splats(GaussianSpans<const float> set, int64_t first, int degree,
                  const int64_t* first_of, int64_t capacity, Splat<float>* splats, TileRect* rects,
                  StepCounters* counters) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= set.count) return;
  const int64_t begin = first_of[first + n], end = first_of[first + n + 1];
  if (begin == end || end > capacity) return;
  float sh[3 * kMaxShCoefficients] = {};
  load_sh(set.at(kSh, n), 3 * set.coefficients, 3 * sh_coefficients(degree), sh);
  bool invalid = false;
  for (int64_t s = begin; s < end; ++s) {
    Vec3<float> drawn;
    uint32_t negative;
    if (!drawn_colour(degree, splats[s].colour, sh, drawn, negative)) {
      invalid = true;
      rects[s] = {};
      negative = kNotDrawn;
    }
    splats[s].colour = drawn, splats[s].negative = negative;
  }
  if (invalid) atomicAdd(&counters->invalid, 1u);
}

/// Brings the SH of Gaussians that are drawn up to date, a thread per scalar.
__global__ void catch_up_drawn(LazySh<float> lazy, int64_t first, int width,
                               const int64_t* first_of) {
  const int64_t at = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  const int64_t n = at / width;
  if (n >= lazy.last_step.size || first_of[first + n] == first_of[first + n + 1]) return;
  const int64_t last = lazy.last_step[n];
  if (last >= lazy.step) return;
  catch_up_sh(lazy, lazy_gap<float>(lazy.table.data, last, lazy.step), n * width,
              int(at % width));
}

__global__ void mark_drawn(LazySh<float> lazy, int64_t first, const int64_t* first_of) {
  const int64_t n = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (n < lazy.last_step.size && first_of[first + n] != first_of[first + n + 1])
    lazy.last_step[n] = int32_t(lazy.step);
}

/// Tiles of each splat, and of all of them in 64 bits.
__global__ void __launch_bounds__(kThreads)
    count_tiles(BoundsOptions bounds, bool balanced, const ViewArgs<float>* views,
                const Splat<float>* splats, const TileRect* rects, int64_t capacity,
                int32_t* tiles, StepCounters* counters) {
  const int64_t s = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  const bool on = s < min(int64_t(counters->splats), capacity);
  Splat<float> splat{};
  TileRect rect{};
  if (on) splat = splats[s], rect = rects[s];
  int count = 0;
  walk_tiles(bounds, balanced, splat.footprint(), rect, on ? views[splat.view].tiles_x : 0,
             [&](int) { ++count; }, [&](int more) { count += more; });
  if (on) tiles[s] = count;
  unsigned long long sum = (unsigned long long)count;
  for (int step = 16; step > 0; step /= 2) sum += __shfl_down_sync(~0u, sum, step);
  if (threadIdx.x % 32 == 0 && sum > 0) atomicAdd(&counters->instances, sum);
}

__global__ void store_total(const int64_t* total, StepCounters* counters) {
  counters->splats = (unsigned long long)*total;
}

}  // namespace

void CudaBackend::write_splats(const ProjectArgs<float>& args, Splats<float>& splats) {
  const int64_t capacity = splats.splat.size();
  int64_t first = 0;
  for (int set = 0; set < 2; ++set) {
    const GaussianSpans<const float>& spans = args.sets[set];
    if (spans.count == 0) continue;
    const SetArgs a{spans,
                    first,
                    views_of(*args.batch),
                    int(args.batch->views.size()),
                    float(args.options.near_plane),
                    float(args.options.far_plane),
                    args.options.kernels.bounds,
                    args.options.sliced_direction};
    const unsigned grid = grid_of(spans.count, kThreads);
    const auto write = spans.dim == 4 ? write_views<4> : write_views<3>;
    write<<<grid, kThreads, 0, stream_>>>(a, splats.first_of.data(), capacity, splats.splat.data(),
                                          splats.depth.data(), splats.rect.data());
    const LazySh<float>& lazy = args.lazy[set];
    if (!lazy.last_step.empty()) {
      const int width = 3 * spans.coefficients;
      constexpr int kMany = 256;
      catch_up_drawn<<<grid_of(spans.count * width, kMany), kMany, 0, stream_>>>(
          lazy, first, width, splats.first_of.data());
      mark_drawn<<<grid_of(spans.count, kMany), kMany, 0, stream_>>>(lazy, first,
                                                                     splats.first_of.data());
    }
    const int degree = min_of(args.options.sh_degree, sh_degree_of(spans.coefficients));
    colour_splats<<<grid, kThreads, 0, stream_>>>(spans, first, degree, splats.first_of.data(),
                                                  capacity, splats.splat.data(),
                                                  splats.rect.data(), counters_.data());
    check_launch("project: write_views, colour_splats");
    first += spans.count;
  }
  count_tiles<<<grid_of(capacity, kThreads), kThreads, 0, stream_>>>(
      args.options.kernels.bounds, args.options.kernels.balanced_instances, views_of(*args.batch),
      splats.splat.data(), splats.rect.data(), capacity, splats.tiles.data(), counters_.data());
  check_launch("project: count_tiles");
  check_device(cudaMemcpyAsync(counters_host_.data(), counters_.data(), sizeof(StepCounters),
                               cudaMemcpyDeviceToHost, stream_),
               "copy of counters");
  // the one wait of a step: the sizes of what comes next
  check_device(cudaStreamSynchronize(stream_), "waiting for project");
}

void CudaBackend::project(const ProjectArgs<float>& args, Splats<float>& splats) {
  const int64_t gaussians = args.sets[0].count + args.sets[1].count;
  visible_.resize(gaussians);
  splats.first_of.resize(gaussians + 1);
  check_device(cudaMemsetAsync(counters_.data(), 0, sizeof(StepCounters), stream_), "memset");
  int64_t first = 0;
  for (int set = 0; set < 2; ++set) {
    const GaussianSpans<const float>& spans = args.sets[set];
    if (spans.count == 0) continue;
    const SetArgs a{spans,
                    first,
                    views_of(*args.batch),
                    int(args.batch->views.size()),
                    float(args.options.near_plane),
                    float(args.options.far_plane),
                    args.options.kernels.bounds,
                    args.options.sliced_direction};
    const auto count = spans.dim == 4 ? count_views<4> : count_views<3>;
    count<<<grid_of(spans.count, kThreads), kThreads, 0, stream_>>>(a, visible_.data(),
                                                                    counters_.data());
    first += spans.count;
  }
  check_launch("project: count_views");
  exclusive_sums(stream_, visible_.span(), splats.first_of.span(), scratch_);
  store_total<<<1, 1, 0, stream_>>>(splats.first_of.data() + gaussians, counters_.data());

  // room for as many splats as there have ever been; once more where that is too little
  const auto resize = [&](int64_t count) {
    splats.splat.resize(count), splats.depth.resize(count), splats.rect.resize(count);
    splats.tiles.resize(count);
  };
  resize(splats.splat.capacity());
  write_splats(args, splats);
  if (int64_t(counters_host_.data()->splats) > splats.splat.size()) {
    const int64_t wanted = int64_t(counters_host_.data()->splats);
    resize(wanted + wanted / 8);
    return project(args, splats);
  }
  const StepCounters& counted = *counters_host_.data();
  splats.count = int64_t(counted.splats), splats.instances = int64_t(counted.instances);
  splats.invalid = counted.invalid;
  resize(splats.count);
  double bytes = 48.0 * double(gaussians) + double(splats.count) * (60 + 28);
  for (const GaussianSpans<const float>& spans : args.sets)
    bytes += double(spans.count) * 4 * (spans.dim == 4 ? 17 : 11);
  const int degree = args.options.sh_degree;
  clock_.add_bytes(kProject, bytes + double(splats.count) * 12 * sh_coefficients(degree));
}

}  // namespace tessera
