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
#include "kernels/cuda/sh_registers.cuh"
#include "kernels/stages/regulariser.h"
#include "kernels/stages/splat_gradient.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;
constexpr int kShThreads = 192;

struct Backward {
  GaussianSpans<const float> set;
  int64_t first;  // Gaussians before this set
  const ViewArgs<float>* views;
  int view_count, degree;
  bool sliced_direction;
  SplatRules<float> rules;
  const Splat<float>* splats;
  const int32_t *tiles, *gaussian;
  const int64_t* first_of;
  SplatGradient<float>* d_splats;
  DensityStatistics<float> statistics;
  IdleUpdate idle;
  LazySh<float> lazy;
  RegulariserTerms<float> regulariser;
  StepCounters* counters;
};

/// The gradient by colour and the direction take the place of a splat's gradient once it is used.
__device__ inline void keep_colour(const ColourGradient<float>& colour, SplatGradient<float>& d) {
  d.colour = colour.d_colour;
  d.conic = {colour.direction[0], colour.direction[1], colour.direction[2]};
}

/// One thread a Gaussian: v of all, before any is changed.
template <Form form>
__global__ void __launch_bounds__(kThreads)
    find_velocities(GaussianSpans<const float> set, float* velocities) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n < set.count) store_velocity<form>(set, n, velocities);
}

/// One thread a splat: its share of its Gaussian's sums.
template <Form form>
__global__ void __launch_bounds__(kThreads) splat_backward(Backward a, ViewSums<float>* sums) {
  const int64_t s = a.first_of[a.first] + int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (s >= a.first_of[a.first + a.set.count]) return;
  const int64_t n = a.gaussian[s] - a.first;
  ViewSums<float> sum;
  GaussianState<float> g;
  const Splat<float> splat = a.splats[s];
  if (splat.negative != kNotDrawn && load_gaussian<form>(a.set, n, g)) {
    float sh[3 * kMaxShCoefficients] = {};
    load_sh(g.sh, 3 * a.set.coefficients, 3 * sh_coefficients(a.degree), sh);
    const SplatGradient<float> d = a.d_splats[s];
    keep_colour(add_view_gradient(a.views[splat.view], g, sh, a.degree, a.sliced_direction, a.rules,
                                  splat, d, sum),
                a.d_splats[s]);
  }
  sums[s] = sum;
}

/// One thread a Gaussian: what its splats found, through its stored parameters, into the sink.
template <Form form, class Sink>
__global__ void __launch_bounds__(kThreads)
    geometry_backward(Backward a, const ViewSums<float>* view_sums, Sink sink) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= a.set.count) return;
  const int64_t begin = a.first_of[a.first + n], end = a.first_of[a.first + n + 1];
  if (begin == end && a.idle == IdleUpdate::kSkip) return;
  GeometryGradient<float> gradient;
  GaussianState<float> g;
  const bool regularised = a.regulariser.in_spacetime<form>();
  if ((begin < end || regularised) && load_gaussian<form>(a.set, n, g)) {
    ViewSums<float> sums;
    int seen = 0;
    for (int64_t s = begin; s < end; ++s) {
      sums += view_sums[s];
      seen += a.tiles[s] > 0;
    }
    if (regularised) add_spacetime_regulariser(a.regulariser, n, g.spacetime, sums.spacetime);
    gradient = geometry_gradient<form>(a.set, n, g, sums);
    if (seen > 0 && !a.statistics.count.empty()) {
      // per-image gradients: the batch loss is their mean, so multiply by B, divide by n_v
      a.statistics.gradient_sum[n] += sums.ndc_norms * float(a.view_count) / float(seen);
      a.statistics.count[n] += 1.0f;
    }
  }
  add_regulariser<form>(a.regulariser, a.set, n, gradient);
  const unsigned bad = gradient.template non_finite<form>();
  if (bad != 0) atomicOr(&a.counters->bad_groups, bad);
  sink.template accept<form>(n, gradient);
}

/// Neighbouring SH scalars into a sink, with one access of 16 bytes to each array where there
/// are 4.
template <int Scalars>
__device__ inline void accept_sh(const StoreGradient<float>& sink, int64_t n, int first,
                                 const float (&g)[Scalars]) {
  for (int j = 0; j < Scalars; ++j) sink.accept_sh(n, first + j, g[j]);
}
template <int Scalars>
__device__ inline void accept_sh(const ApplyAdam<float>& sink, int64_t n, int first,
                                 const float (&g)[Scalars]) {
  struct alignas(4 * Scalars) Lane {
    float at[Scalars];
  };
  Lane& value = reinterpret_cast<Lane&>(sink.value.at(kSh, n)[first]);
  Lane& moment1 = reinterpret_cast<Lane&>(sink.moment1.at(kSh, n)[first]);
  Lane& moment2 = reinterpret_cast<Lane&>(sink.moment2.at(kSh, n)[first]);
  Lane x = value, m = moment1, v = moment2;
  TESSERA_UNROLL
  for (int j = 0; j < Scalars; ++j)
    adam_step(first + j < 3 ? sink.adam.group[kSh] : sink.adam.sh_rest, g[j], x.at[j], m.at[j],
              v.at[j]);
  value = x, moment1 = m, moment2 = v;
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

/// A thread has `Scalars` neighbouring ones of a Gaussian's coefficients: 4 where rows allow it.
template <int Scalars, class Sink>
__global__ void __launch_bounds__(kShThreads) sh_backward(Backward a, Sink sink, bool stores) {
  const int64_t at = int64_t(blockIdx.x) * kShThreads + threadIdx.x;
  const int per_gaussian = 3 * a.set.coefficients / Scalars;
  const int64_t n = at / per_gaussian;
  if (n >= a.set.count) return;
  const int first = int(at - n * per_gaussian) * Scalars, k = first / 3;
  const int64_t begin = a.first_of[a.first + n], end = a.first_of[a.first + n + 1];
  if (begin == end && a.idle != IdleUpdate::kDense) return;
  if (a.idle == IdleUpdate::kLazy && first == 0) a.lazy.last_step[n] = int32_t(a.lazy.step + 1);
  // coefficients of bands that are not active yet have neither gradient nor moments
  if (k >= sh_coefficients(a.degree) && !stores) return;
  float sum[Scalars] = {};
  for (int64_t s = begin; s < end; ++s) {
    const SplatGradient<float>& d = a.d_splats[s];
    const Vec3<float> direction(d.conic.xx, d.conic.xy, d.conic.yy);
    const float2 Y = two_of_basis(a.degree, direction, k);
    const float red = d.colour[0], green = d.colour[1], blue = d.colour[2];
    TESSERA_UNROLL
    for (int j = 0; j < Scalars; ++j) {
      const int c = (first + j) % 3;
      sum[j] += ((first + j) / 3 == k ? Y.x : Y.y) * (c == 0 ? red : c == 1 ? green : blue);
    }
  }
  float check = 0;
  for (int j = 0; j < Scalars; ++j) check += sum[j] - sum[j];
  if (!(check == 0.0f)) atomicOr(&a.counters->bad_groups, 1u << kSh);
  accept_sh<Scalars>(sink, n, first, sum);
}

template <Form form, class Sink>
void backward_set(const Backward& a, int64_t splats, ViewSums<float>* sums, const Sink& sink,
                  bool stores, cudaStream_t stream) {
  splat_backward<form><<<grid_of(splats, kThreads), kThreads, 0, stream>>>(a, sums);
  check_launch("project_backward: splat_backward");
  geometry_backward<form, Sink>
      <<<grid_of(a.set.count, kThreads), kThreads, 0, stream>>>(a, sums, sink);
  check_launch("project_backward: geometry_backward");
  const int row = 3 * a.set.coefficients;
  const auto sh = row % 4 == 0 ? sh_backward<4, Sink> : sh_backward<1, Sink>;
  const int64_t threads = a.set.count * (row % 4 == 0 ? row / 4 : row);
  sh<<<grid_of(threads, kShThreads), kShThreads, 0, stream>>>(a, sink, stores);
  check_launch("project_backward: sh_backward");
}

template <class Sink>
void backward_set(const Backward& a, int64_t splats, ViewSums<float>* sums, const Sink& sink,
                  bool stores, cudaStream_t stream) {
  with_form(a.set.form,
            [&](auto form) { backward_set<form()>(a, splats, sums, sink, stores, stream); });
}

}  // namespace

void CudaBackend::project_backward(const ProjectBackwardArgs<float>& args) {
  int64_t first = 0;
  scratch_.resize(args.splats->count * int64_t(sizeof(ViewSums<float>)));
  ViewSums<float>* const sums = reinterpret_cast<ViewSums<float>*>(scratch_.data());
  const GaussianSpans<const float>& moving = args.forward.sets[1];
  velocities_.resize(args.pairs.first.empty() ? 0 : 3 * moving.count);
  if (!velocities_.empty()) {
    with_form(moving.form, [&](auto form) {
      find_velocities<form()>
          <<<grid_of(moving.count, kThreads), kThreads, 0, stream_>>>(moving, velocities_.data());
    });
    check_launch("project_backward: find_velocities");
  }
  const RegulariserTerms<float> terms(args.regulariser, args.pairs,
                                      std::as_const(velocities_).span(), args.forward.sets[0].count,
                                      moving.count);
  double bytes = double(args.splats->count) * (48 + 36 * 2 + 24 * 2 + 64 * 2);
  for (int set = 0; set < 2; ++set) {
    const GaussianSpans<const float>& spans = args.forward.sets[set];
    if (spans.count == 0) continue;
    const SinkArgs<float>& sink = args.sinks[set];
    const Backward a{spans,
                     first,
                     views_of(*args.forward.batch),
                     int(args.forward.batch->views.size()),
                     min_of(args.forward.options.sh_degree, sh_degree_of(spans.coefficients)),
                     args.forward.options.sliced_direction,
                     make_splat_rules<float>(args.forward.options),
                     args.splats->splat.data(),
                     args.splats->tiles.data(),
                     args.splats->gaussian.data(),
                     args.splats->first_of.data(),
                     args.d_splats.data,
                     args.statistics[set],
                     sink.fused ? sink.idle : IdleUpdate::kDense,
                     sink.lazy,
                     terms,
                     counters_.data()};
    if (sink.fused)
      backward_set(a, args.splats->count, sums,
                   ApplyAdam<float>{sink.value, sink.moment1, sink.moment2, sink.adam}, false,
                   stream_);
    else
      backward_set(a, args.splats->count, sums, StoreGradient<float>{sink.gradient}, true, stream_);
    first += spans.count;
    const double scalars = geometry_scalars(spans.form) + 3 * spans.coefficients;
    bytes += double(spans.count) * (8 + scalars * (sink.fused ? 24 : 8));
  }
  report();
  clock_.add_bytes(kProjectBackward, bytes);
}

}  // namespace tessera
