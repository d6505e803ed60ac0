// Projection of Gaussians to the splats of every view on the device. One thread for each Gaussian
// finds the views that draw it; after a scan, one thread computes each splat. A loop over views
// would leave most lanes of a warp idle, because in 4D most Gaussians are not drawn in most views.
// The file is compiled without contraction to fused multiply-adds, because the two passes must
// decide alike. Source: method A.5–A.8; order of the splats without atomics: method 0.27.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_memory.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/sh_registers.cuh"
#include "kernels/cuda/sort.h"
#include "kernels/load_gaussian.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;
constexpr int kWriteBlocks = 5;  // of write_splats_of on a multiprocessor

/// What all passes need of a set, or of a block of it where they draw colours; Gaussian n of it is
/// number first + n of both sets.
struct SetArgs {
  GaussianSpans<const float> set;
  int64_t first;
  const ViewArgs<float>* views;
  int view_count;
  SplatRules<float> rules;
  ColourRules<float> colours;
};

/// A bit for each view that draws a Gaussian, in `words` words, and how many there are.
template <SetForm form>
__global__ void __launch_bounds__(kThreads)
    count_views(SetArgs a, int words, uint32_t* seen_by, int32_t* visible, StepCounters* counters) {
  const int64_t n = linear_index();
  if (n >= a.set.count) return;
  GaussianState<float> g;
  const bool valid = load_gaussian<form>(a.set, n, g);
  if (!valid) atomicAdd(&counters->invalid, 1u);
  int count = 0;
  for (int word = 0; word < words; ++word) {
    uint32_t bits = 0;
    for (int b = 32 * word; valid && b < min(a.view_count, 32 * word + 32); ++b) {
      ViewSplat<float> splat;
      GaussianState<float> room;
      if (splat_in_view(a.views[b], state_in_view<form>(a.set, n, b, g, room), a.rules, splat))
        bits |= 1u << (b - 32 * word);
    }
    seen_by[(a.first + n) * words + word] = bits;
    count += __popc(bits);
  }
  visible[a.first + n] = count;
}

/// Which Gaussian and view each splat is of, and how many there are.
__global__ void list_splats(const uint32_t* seen_by, int words, int64_t gaussians,
                            const int64_t* first_of, int64_t capacity, int32_t* gaussian,
                            int32_t* view, StepCounters* counters) {
  const int64_t n = linear_index();
  if (n >= gaussians) return;
  if (n == 0) counters->splats = (unsigned long long)first_of[gaussians];
  int64_t s = first_of[n];
  for (int word = 0; word < words; ++word)
    for (uint32_t bits = seen_by[n * words + word]; bits != 0; bits &= bits - 1, ++s) {
      if (s >= capacity) return;
      gaussian[s] = int32_t(n);
      view[s] = 32 * word + __ffs(int(bits)) - 1;
    }
}

struct SplatTargets {
  const int64_t* first_of;
  const int32_t *gaussian, *view;
  int64_t capacity;
  Splat<float>* splat;
  float* depth;
  TileRect* rect;
  int32_t* tiles;
  ColourSlope<float>* slope;  // null: not wanted
  Vec3<float>* time_slope;    // null: not wanted, or no levels
};

/// Splat s of a set: where it lies, its colour, how far it reaches. False when its colour is not
/// finite: then it stays in the list, but is not drawn.
template <SetForm form>
__device__ inline bool make_splat(const SetArgs& a, const SplatTargets& out, int64_t s,
                                  Splat<float>& splat, TileRect& rect) {
  const int64_t n = out.gaussian[s] - a.first;
  const int b = out.view[s];
  const ColourRules<float> colours = rules_of<form>(a.colours);
  GaussianState<float> at_rest, room;
  ViewSplat<float> in_view;
  load_gaussian<form>(a.set, n, at_rest);
  const GaussianState<float>& g = state_in_view<form>(a.set, n, b, at_rest, room);
  splat_in_view(a.views[b], g, a.rules, in_view);
  splat.mean2d = in_view.projection.mean2d;
  splat.conic = in_view.projection.conic;
  splat.opacity = in_view.opacity;
  splat.power = in_view.power;
  splat.view = b;
  out.depth[s] = in_view.projection.in_cam[2];
  rect = in_view.rect;
  float sh[3 * kMaxShCoefficients] = {}, distance;
  load_sh(colours, g, colour_delta(a.views[b], g), sh);
  const Vec3<float> direction =
      view_direction(a.views[b], colours.sliced_direction ? in_view.slice.mean : g.mean, distance);
  const bool finite = drawn_colour(colours.degree, direction, sh, splat.colour, splat.negative);
  if (out.slope != nullptr) out.slope[s] = colour_slope(colours.degree, direction, distance, sh);
  if (out.time_slope != nullptr && colours.levels > 0)
    out.time_slope[s] = levels_slope(colours, colour_delta(a.views[b], g), g.sh_time, direction);
  if (!finite) {
    splat.negative = kNotDrawn;
    rect = {};
  }
  return finite;
}

/// One thread a splat; the tiles of each, and of all of them in 64 bits.
template <SetForm form>
__global__ void __launch_bounds__(kThreads, kWriteBlocks)
    write_splats_of(SetArgs a, SplatTargets out, StepCounters* counters) {
  const int64_t s = out.first_of[a.first] + linear_index();
  const bool on = s < min(out.first_of[a.first + a.set.count], out.capacity);
  Splat<float> splat{};
  TileRect rect{};
  int count = 0;
  if (on) {
    if (!make_splat<form>(a, out, s, splat, rect) && s == out.first_of[out.gaussian[s]])
      atomicAdd(&counters->invalid, 1u);
    count = rect.area();
    out.splat[s] = splat;
    out.rect[s] = rect;
    out.tiles[s] = count;
  }
  unsigned long long sum = (unsigned long long)count;
  for (int step = 16; step > 0; step /= 2) sum += __shfl_down_sync(~0u, sum, step);
  if (threadIdx.x % 32 == 0 && sum > 0) atomicAdd(&counters->instances, sum);
}

SetArgs set_args(const ProjectArgs<float>& args, const GaussianSpans<const float>& spans,
                 int64_t first, const ViewArgs<float>* views) {
  return {spans,
          first,
          views,
          int(args.batch->views.size()),
          make_splat_rules<float>(args.options),
          make_colour_rules<float>(args.options, spans.coefficients, spans.time_levels)};
}

}  // namespace

void CudaBackend::write_splats(const ProjectArgs<float>& args, Splats<float>& splats) {
  const int64_t capacity = splats.splat.size();
  const int64_t gaussians = args.sets[0].count + args.sets[1].count;
  Scratch scratch(scratch_);
  scratch.plan<int32_t>(capacity);
  scratch.allocate();
  const Span<int32_t> view = scratch.take<int32_t>(capacity);
  const int words = int(args.batch->views.size() + 31) / 32;
  launch_linear<256>(stream_, "project: list_splats", list_splats, gaussians, seen_by_.data(),
                     words, gaussians, splats.first_of.data(), capacity, splats.gaussian.data(),
                     view.data, counters_.data());
  const SplatTargets out{splats.first_of.data(),
                         splats.gaussian.data(),
                         view.data,
                         capacity,
                         splats.splat.data(),
                         splats.depth.data(),
                         splats.rect.data(),
                         splats.tiles.data(),
                         splats.slope.empty() ? nullptr : splats.slope.data(),
                         splats.time_slope.empty() ? nullptr : splats.time_slope.data()};
  for (int set = 0; set < 2; ++set) {
    const GaussianSpans<const float>& spans = args.sets[set];
    if (spans.count == 0) continue;
    const int64_t first = set == 0 ? 0 : args.sets[0].count;
    for_each_block(spans.blocks, spans.count, spans.coefficients, [&](const ShBlock& elements) {
      const SetArgs a =
          set_args(args, spans.block(elements), first + elements.first, views_of(*args.batch));
      with_drawn_form(spans.form, [&](auto form) {
        launch_linear<kThreads>(stream_, "project: write_splats_of", write_splats_of<form()>,
                                capacity, a, out, counters_.data());
      });
    });
  }
  check_device(cudaMemcpyAsync(counters_host_.data(), counters_.data(), sizeof(StepCounters),
                               cudaMemcpyDeviceToHost, stream_),
               "copy of counters");
  // the one wait of a step: the sizes of what comes next
  check_device(cudaStreamSynchronize(stream_), "waiting for project");
}

void CudaBackend::project(const ProjectArgs<float>& args, Splats<float>& splats) {
  const int64_t gaussians = args.sets[0].count + args.sets[1].count;
  check_gaussian_count(gaussians);  // list_splats writes their numbers in 32 bits
  const int words = int(args.batch->views.size() + 31) / 32;
  visible_.resize(gaussians);
  seen_by_.resize(gaussians * words);
  splats.first_of.resize(gaussians + 1);
  check_device(cudaMemsetAsync(counters_.data(), 0, sizeof(StepCounters), stream_), "memset");
  for (int set = 0; set < 2; ++set) {
    const GaussianSpans<const float>& spans = args.sets[set];
    if (spans.count == 0) continue;
    with_drawn_form(spans.form, [&](auto form) {
      launch_linear<kThreads>(
          stream_, "project: count_views", count_views<form()>, spans.count,
          set_args(args, spans, set == 0 ? 0 : args.sets[0].count, views_of(*args.batch)), words,
          seen_by_.data(), visible_.data(), counters_.data());
    });
  }
  exclusive_sums(stream_, visible_.span(), splats.first_of.span(), sort_scratch_);

  const int levels = min_of(args.options.sh_time_degree, args.sets[1].time_levels);
  // room for as many splats as there have ever been; once more where that is too little
  const auto resize = [&](int64_t count) {
    splats.splat.resize(count);
    splats.depth.resize(count);
    splats.rect.resize(count);
    splats.tiles.resize(count);
    splats.gaussian.resize(count);
    splats.slope.resize(args.for_backward ? count : 0);
    splats.time_slope.resize(args.for_backward && levels > 0 ? count : 0);
  };
  resize(splats.splat.capacity());
  write_splats(args, splats);
  if (int64_t(counters_host_.data()->splats) > splats.splat.size()) {
    const int64_t wanted = int64_t(counters_host_.data()->splats);
    resize(wanted + wanted / 8);
    return project(args, splats);
  }
  const StepCounters& counted = *counters_host_.data();
  splats.count = int64_t(counted.splats);
  splats.instances = int64_t(counted.instances);
  splats.invalid = counted.invalid;
  resize(splats.count);
  double bytes = 20.0 * double(gaussians) +
                 double(splats.count) * (8 + 48 + 4 + 8 + 4 + (args.for_backward ? 48 : 0));
  for (const GaussianSpans<const float>& spans : args.sets)
    bytes += double(spans.count) * 4 * geometry_scalars(spans.form);
  const int degree = args.options.sh_degree;
  clock_.add_bytes(kProject,
                   bytes + (1 + levels) * double(splats.count) * 12 * sh_coefficients(degree));
}

}  // namespace tessera
