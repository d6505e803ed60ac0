// What: splat gradients → parameter gradients into a sink, on the device. One thread a splat finds
// its share of its Gaussian's sums; one thread a Gaussian adds them up, for all but SH; then a
// thread for every four SH scalars, so that whole lines are read and written.
// Not: equations (stages/splat_gradient.h). Compiled without contraction to fused multiply-adds, so
// that fused and separate Adam agree to the bit.
// Source: method A.12, A.16, D.6, G.4.
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/sh_registers.cuh"
#include "kernels/elements/load_gaussian.h"
#include "kernels/stages/regulariser.h"
#include "kernels/stages/splat_gradient.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;
constexpr int kShThreads = 192;

/// Of a set, or of a block of it where colours are read.
struct Backward {
  GaussianSpans<const float> set;
  int64_t first;  // Gaussians before it
  const ViewArgs<float>* views;
  int view_count;
  ColourRules<float> colours;
  SplatRules<float> rules;
  const Splat<float>* splats;
  const int32_t *tiles, *gaussian;
  const int64_t* first_of;
  SplatGradient<float>* d_splats;
  DensityStatistics<float> statistics;
  IdleUpdate idle;
  RegulariserTerms<float> regulariser;
  StepCounters* counters;
};

/// What the SH need takes the place of a splat's gradient once it is used: the gradient by colour,
/// the direction, Δ.
__device__ inline void keep_colour(const ColourGradient<float>& colour, SplatGradient<float>& d) {
  d.colour = colour.d_colour;
  d.opacity = colour.delta;
  d.conic = {colour.direction[0], colour.direction[1], colour.direction[2]};
}

/// One thread a splat: its share of its Gaussian's sums.
template <Form form>
__global__ void __launch_bounds__(kThreads) splat_backward(Backward a, ViewSums<float>* sums) {
  const int64_t s = a.first_of[a.first] + linear_index();
  if (s >= a.first_of[a.first + a.set.count]) return;
  const int64_t n = a.gaussian[s] - a.first;
  ViewSums<float> sum;
  GaussianState<float> g;
  const Splat<float> splat = a.splats[s];
  if (splat.negative != kNotDrawn && load_gaussian<form>(a.set, n, g)) {
    const ColourRules<float> colours = rules_of<form>(a.colours);
    const ViewArgs<float>& view = a.views[splat.view];
    float sh[3 * kMaxShCoefficients] = {};
    load_sh(colours, g, view.time - g.spacetime.mean_time, sh);
    const SplatGradient<float> d = a.d_splats[s];
    keep_colour(add_view_gradient(view, g, sh, colours, a.rules, splat, d, sum), a.d_splats[s]);
  }
  sums[s] = sum;
}

/// One thread a Gaussian: what its splats found, through its stored parameters, into the sink.
template <Form form, class Sink>
__global__ void __launch_bounds__(kThreads)
    geometry_backward(Backward a, const ViewSums<float>* view_sums, Sink sink) {
  const int64_t n = linear_index();
  if (n >= a.set.count) return;
  const int64_t begin = a.first_of[a.first + n], end = a.first_of[a.first + n + 1];
  if (begin == end && a.idle == IdleUpdate::kSkip) return;
  GeometryGradient<float> gradient;
  GaussianState<float> g;
  int seen = 0;
  if (begin < end && load_gaussian<form>(a.set, n, g)) {
    ViewSums<float> sums;
    for (int64_t s = begin; s < end; ++s) {
      sums += view_sums[s];
      seen += a.tiles[s] > 0;
    }
    gradient = geometry_gradient<form>(a.set, n, g, sums);
    if (seen > 0 && !a.statistics.count.empty()) {
      a.statistics.gradient_sum[n] += mean_view_norm(sums.ndc_norms, a.view_count, seen);
      a.statistics.count[n] += 1.0f;
    }
  }
  add_regulariser<form>(a.regulariser, a.set, n, float(seen) / float(a.view_count), gradient);
  const unsigned bad = gradient.template non_finite<form>();
  if (bad != 0) atomicOr(&a.counters->bad_groups, bad);
  sink.template accept<form>(n, gradient);
}

/// Neighbouring SH scalars into a sink, with one access of 16 bytes to each array where there
/// are 4.
template <Group group, int Scalars>
__device__ inline void accept_sh(const StoreGradient<float>& sink, int64_t n, int first,
                                 const float (&g)[Scalars]) {
  for (int j = 0; j < Scalars; ++j) sink.accept_sh(group, n, first + j, g[j]);
}
template <Group group, int Scalars>
__device__ inline void accept_sh(const ApplyAdam<float>& sink, int64_t n, int first,
                                 const float (&g)[Scalars]) {
  struct alignas(4 * Scalars) Lane {
    float value[Scalars];
  };
  Lane& value = reinterpret_cast<Lane&>(sink.value.at(group, n)[first]);
  Lane& moment1 = reinterpret_cast<Lane&>(sink.moment1.at(group, n)[first]);
  Lane& moment2 = reinterpret_cast<Lane&>(sink.moment2.at(group, n)[first]);
  Lane x = value, m = moment1, v = moment2;
  TESSERA_UNROLL
  for (int j = 0; j < Scalars; ++j)
    adam_step(sink.sh_scalars(group, first + j), g[j], x.value[j], m.value[j], v.value[j]);
  value = x;
  moment1 = m;
  moment2 = v;
}

/// Basis functions k and k + 1 at a direction; k differs between lanes.
__device__ inline float2 two_of_basis(int degree, const Vec3<float>& direction, int k) {
  float Y[kMaxShCoefficients + 1] = {};
  sh_basis(degree, direction, Y);
  float2 two{0, 0};
  TESSERA_UNROLL
  for (int j = 0; j < kMaxShCoefficients; ++j)
    if (j == k) two = {Y[j], Y[j + 1]};
  return two;
}

/// A thread has `Scalars` neighbouring ones of a Gaussian's coefficients, all of one level of time:
/// 4 where elements allow it.
template <Group group, int Scalars, class Sink>
__global__ void __launch_bounds__(kShThreads) sh_backward(Backward a, Sink sink, bool stores) {
  const int64_t scalar = linear_index();
  const int per_gaussian = a.set.width(group) / Scalars;
  const int64_t n = scalar / per_gaussian;
  if (n >= a.set.count) return;
  const int first = int(scalar - n * per_gaussian) * Scalars;
  const int level = group == kShTime ? 1 + first / a.colours.row : 0;
  const int in_level = group == kShTime ? first - (level - 1) * a.colours.row : first;
  const int k = in_level / 3;
  const int64_t begin = a.first_of[a.first + n], end = a.first_of[a.first + n + 1];
  if (begin == end && a.idle != IdleUpdate::kDense) return;
  // coefficients of bands and levels that are not active yet have neither gradient nor moments
  const bool active = k < sh_coefficients(a.colours.degree) && level <= a.colours.levels;
  if (!active && !stores) return;
  float sum[Scalars] = {};
  for (int64_t s = active ? begin : end; s < end; ++s) {
    const SplatGradient<float>& d = a.d_splats[s];
    const Vec3<float> direction(d.conic.xx, d.conic.xy, d.conic.yy);
    const float2 Y = two_of_basis(a.colours.degree, direction, k);
    const float weight = group == kShTime ? level_weight(a.colours, level, d.opacity) : 1.0f;
    const float red = d.colour[0], green = d.colour[1], blue = d.colour[2];
    TESSERA_UNROLL
    for (int j = 0; j < Scalars; ++j) {
      const int c = (in_level + j) % 3;
      sum[j] += sh_gradient((in_level + j) / 3 == k ? Y.x : Y.y, weight,
                            c == 0   ? red
                            : c == 1 ? green
                                     : blue);
    }
  }
  float check = 0;
  for (int j = 0; j < Scalars; ++j) check += sum[j] - sum[j];
  if (!(check == 0.0f)) atomicOr(&a.counters->bad_groups, 1u << group);
  accept_sh<group>(sink, n, first, sum);
}

template <Group group, class Sink>
void backward_sh(const Backward& a, const Sink& sink, bool stores, cudaStream_t stream) {
  if (a.set.width(group) == 0) return;
  const bool fours = a.colours.row % 4 == 0;
  const auto kernel = fours ? sh_backward<group, 4, Sink> : sh_backward<group, 1, Sink>;
  const int64_t threads = a.set.count * a.set.width(group) / (fours ? 4 : 1);
  launch_linear<kShThreads>(stream, "project_backward: sh_backward", kernel, threads, a, sink,
                            stores);
}

template <class Sink>
Sink sink_of(const SinkArgs<float>& args) {
  if constexpr (std::is_same_v<Sink, ApplyAdam<float>>)
    return {args.value, args.moment1, args.moment2, args.adam};
  else
    return {args.gradient};
}

template <Form form, class Sink>
void backward_set(const Backward& a, const RenderOptions& options, int64_t splats,
                  ViewSums<float>* sums, const SinkArgs<float>& args, cudaStream_t stream) {
  const auto each_block = [&](auto&& launch) {
    for_each_block(a.set.blocks, a.set.count, a.set.coefficients, [&](const ShBlock& elements) {
      Backward block = a;
      block.set = a.set.block(elements);
      block.first = a.first + elements.first;
      block.colours =
          make_colour_rules<float>(options, block.set.coefficients, block.set.time_levels);
      launch(block, elements);
    });
  };
  each_block([&](const Backward& block, const ShBlock&) {
    launch_linear<kThreads>(stream, "project_backward: splat_backward", splat_backward<form>,
                            splats, block, sums);
  });
  launch_linear<kThreads>(stream, "project_backward: geometry_backward",
                          geometry_backward<form, Sink>, a.set.count, a, sums, sink_of<Sink>(args));
  each_block([&](const Backward& block, const ShBlock& elements) {
    const Sink sink = sink_of<Sink>(args.block(elements));
    backward_sh<kSh>(block, sink, !args.fused, stream);
    if constexpr (form != Form::kStatic) backward_sh<kShTime>(block, sink, !args.fused, stream);
  });
}

}  // namespace

void CudaBackend::project_backward(const ProjectBackwardArgs<float>& args) {
  int64_t first = 0;
  scratch_.resize(args.splats->count * int64_t(sizeof(ViewSums<float>)));
  ViewSums<float>* const sums = reinterpret_cast<ViewSums<float>*>(scratch_.data());
  const RegulariserTerms<float> terms(args.regulariser,
                                      args.forward.sets[0].count + args.forward.sets[1].count);
  double bytes = double(args.splats->count) * (48 + 36 * 2 + 24 * 2 + 64 * 2);
  for (int set = 0; set < 2; ++set) {
    const GaussianSpans<const float>& spans = args.forward.sets[set];
    if (spans.count == 0) continue;
    const SinkArgs<float>& sink = args.sinks[set];
    const Backward a{spans,
                     first,
                     views_of(*args.forward.batch),
                     int(args.forward.batch->views.size()),
                     {},
                     make_splat_rules<float>(args.forward.options),
                     args.splats->splat.data(),
                     args.splats->tiles.data(),
                     args.splats->gaussian.data(),
                     args.splats->first_of.data(),
                     args.d_splats.data,
                     args.statistics[set],
                     sink.fused ? sink.idle : IdleUpdate::kDense,
                     terms,
                     counters_.data()};
    with_form(spans.form, [&](auto form) {
      const auto run = sink.fused ? backward_set<form(), ApplyAdam<float>>
                                  : backward_set<form(), StoreGradient<float>>;
      run(a, args.forward.options, args.splats->count, sums, sink, stream_);
    });
    first += spans.count;
    const double scalars = double(spans.count) * geometry_scalars(spans.form) +
                           double(spans.group[kSh].size + spans.group[kShTime].size);
    bytes += 8 * double(spans.count) + scalars * (sink.fused ? 24 : 8);
  }
  report();
  clock_.add_bytes(kProjectBackward, bytes);
}

}  // namespace tessera
