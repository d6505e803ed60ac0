// What: splat gradients → parameter gradients into a sink, on the device. First one thread a
// Gaussian, for all but SH, summed over its views in registers; then sixteen lanes a Gaussian for
// the SH coefficients, so that they and their moments are read and written in whole lines.
// Not: equations (stages/splat_gradient.h). Compiled without contraction to fused multiply-adds, so
// that fused and separate Adam agree to the bit.
// Source: method A.12, A.16, D.6, G.4.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/stages/splat_gradient.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;
constexpr int kShLanes = 16;  // one a coefficient

struct Backward {
  GaussianSpans<const float> set;
  int64_t first;  // Gaussians before this set
  const ViewArgs<float>* views;
  int view_count, degree;
  const Splat<float>* splats;
  const int32_t* tiles;
  const int64_t* first_of;
  SplatGradient<float>* d_splats;
  DensityStatistics<float> statistics;
  IdleUpdate idle;
  LazySh<float> lazy;
  StepCounters* counters;
};

/// The gradient by colour and the direction take the place of a splat's gradient once it is used.
__device__ inline void keep_colour(const ColourGradient<float>& colour, SplatGradient<float>& d) {
  d.colour = colour.d_colour;
  d.conic = {colour.direction[0], colour.direction[1], colour.direction[2]};
}

template <int Dim, class Sink>
__global__ void __launch_bounds__(kThreads) geometry_backward(Backward a, Sink sink) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= a.set.count) return;
  const int64_t begin = a.first_of[a.first + n], end = a.first_of[a.first + n + 1];
  if (begin == end && a.idle == IdleUpdate::kSkip) return;
  GeometryGradient<float> gradient;
  GaussianState<float> g;
  if (begin < end && load_gaussian<Dim>(a.set, n, g)) {
    ViewSums<float> sums;
    int seen = 0;
    for (int64_t s = begin; s < end; ++s) {
      const SplatGradient<float> d = a.d_splats[s];
      const Splat<float> splat = a.splats[s];
      keep_colour(add_view_gradient(a.views[splat.view], g, a.degree, splat, d, sums),
                  a.d_splats[s]);
      seen += a.tiles[s] > 0;
    }
    gradient = geometry_gradient<Dim>(a.set, n, g, sums);
    const unsigned bad = gradient.template non_finite<Dim>();
    if (bad != 0) atomicOr(&a.counters->bad_groups, bad);
    if (seen > 0 && !a.statistics.count.empty()) {
      // per-image gradients: the batch loss is their mean, so multiply by B, divide by n_v
      a.statistics.gradient_sum[n] += sums.ndc_norms * float(a.view_count) / float(seen);
      a.statistics.count[n] += 1.0f;
    }
  }
  sink.template accept<Dim>(n, gradient);
}

/// Y_k at a direction, for the lane of coefficient k.
__device__ inline float basis_of_lane(int degree, const Vec3<float>& direction, int k) {
  float Y[kMaxShCoefficients] = {};
  sh_basis(degree, direction, Y);
  float mine = 0;
  TESSERA_UNROLL
  for (int j = 0; j < kMaxShCoefficients; ++j) mine = j == k ? Y[j] : mine;
  return mine;
}

template <class Sink>
__global__ void __launch_bounds__(kThreads) sh_backward(Backward a, Sink sink, bool stores) {
  const int64_t at = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  const int64_t n = at / kShLanes;
  const int k = int(at % kShLanes);
  if (n >= a.set.count || k >= a.set.coefficients) return;
  const int64_t begin = a.first_of[a.first + n], end = a.first_of[a.first + n + 1];
  if (begin == end && a.idle != IdleUpdate::kDense) return;
  if (a.idle == IdleUpdate::kLazy && k == 0) a.lazy.last_step[n] = int32_t(a.lazy.step + 1);
  // coefficients of bands that are not active yet have neither gradient nor moments
  if (k >= sh_coefficients(a.degree) && !stores) return;
  Vec3<float> sum(0.0f);
  for (int64_t s = begin; s < end; ++s) {
    const SplatGradient<float>& d = a.d_splats[s];
    const Vec3<float> direction(d.conic.xx, d.conic.xy, d.conic.yy);
    sum += basis_of_lane(a.degree, direction, k) * d.colour;
  }
  if (!(sum[0] - sum[0] + (sum[1] - sum[1]) + (sum[2] - sum[2]) == 0.0f))
    atomicOr(&a.counters->bad_groups, 1u << kSh);
  for (int c = 0; c < 3; ++c) sink.accept_sh(n, 3 * k + c, sum[c]);
}

template <class Sink>
void backward_set(const Backward& a, const Sink& sink, bool stores, cudaStream_t stream) {
  const auto geometry = a.set.dim == 4 ? geometry_backward<4, Sink> : geometry_backward<3, Sink>;
  geometry<<<grid_of(a.set.count, kThreads), kThreads, 0, stream>>>(a, sink);
  check_launch("project_backward: geometry_backward");
  sh_backward<<<grid_of(a.set.count * kShLanes, kThreads), kThreads, 0, stream>>>(a, sink, stores);
  check_launch("project_backward: sh_backward");
}

}  // namespace

void CudaBackend::project_backward(const ProjectBackwardArgs<float>& args) {
  int64_t first = 0;
  double bytes = double(args.splats->count) * (48 + 36 * 2 + 24 * 2);
  for (int set = 0; set < 2; ++set) {
    const GaussianSpans<const float>& spans = args.forward.sets[set];
    if (spans.count == 0) continue;
    const SinkArgs<float>& sink = args.sinks[set];
    const Backward a{spans,
                     first,
                     views_.data(),
                     int(args.forward.batch->views.size()),
                     min_of(args.forward.options.sh_degree, sh_degree_of(spans.coefficients)),
                     args.splats->splat.data(),
                     args.splats->tiles.data(),
                     args.splats->first_of.data(),
                     args.d_splats.data,
                     args.statistics[set],
                     sink.fused ? sink.idle : IdleUpdate::kDense,
                     sink.lazy,
                     counters_.data()};
    if (sink.fused)
      backward_set(a, ApplyAdam<float>{sink.value, sink.moment1, sink.moment2, sink.adam}, false,
                   stream_);
    else
      backward_set(a, StoreGradient<float>{sink.gradient}, true, stream_);
    first += spans.count;
    const double scalars = (spans.dim == 4 ? 17 : 11) + 3 * spans.coefficients;
    bytes += double(spans.count) * (8 + scalars * (sink.fused ? 24 : 8));
  }
  report();
  clock_.add_bytes(kProjectBackward, bytes);
}

}  // namespace tessera
