// Splat gradients to parameter gradients into a sink, on the device. For the SH a thread has four
// neighbouring scalars. For the rest a block has a run of Gaussians: its threads add up their
// splats and pass the gradients on as whole lines of each group. The file is compiled without
// contraction to fused multiply-adds, so that fused and separate Adam agree to the bit. Source:
// method A.12, A.16, D.6, G.4.
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/sh_registers.cuh"
#include "kernels/load_gaussian.h"
#include "kernels/stages/accept_block.cuh"
#include "kernels/stages/splat_gradient.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;
constexpr int kBlocks = 7;       // of geometry_backward on a multiprocessor
constexpr int kShThreads = 192;  // at most
static_assert(3 * kMaxShCoefficients * kMaxTimeLevels <= kShThreads);

/// Of a set, or of a block of it where colours are read.
struct Backward {
  GaussianSpans<const float> set;
  int64_t first;  // Gaussians before it
  const ViewArgs<float>* views;
  int view_count;
  ColourRules<float> colours;
  SplatRules<float> rules;
  const Splat<float>* splats;
  const ColourSlope<float>* slopes;
  const Vec3<float>* time_slopes;  // null where there are no levels
  const int32_t* gaussian;
  const int64_t* first_of;
  const SplatMoments<float>* d_splats;
  const float* lengths;  // null: of no splat
  DensityStatistics<float> statistics;
  IdleUpdate idle;
  RegulariserTerms<float> regulariser;
  StepCounters* counters;
  CarriedGaussian<float>* d_carried;  // of a canonical set: [B, set.carried_stride]
  long long* d_times;  // [2B] added to, in kTimeSteps, times and readouts; null: not asked for
};

template <SetForm form>
constexpr int kSumFloats = int(sizeof(SumsOf<form, float>) / sizeof(float));

/// Values that the threads of a block share.
template <SetForm form>
struct Shared {
  float sums[kSumFloats<form>][kThreads];  // of a splat each
  bool drawn[kThreads];                    // that splat has tiles
};

/// One thread a splat: its share of its Gaussian's sums, and of those of its view where asked for.
template <SetForm form>
__device__ inline SumsOf<form, float> splat_sums(const Backward& a, int64_t s, bool& drawn,
                                                 TimeGradient<float>& by_time) {
  SumsOf<form, float> sums;
  GaussianState<float> at_rest, room;
  const int64_t n = a.gaussian[s] - a.first;
  const Splat<float> splat = a.splats[s];
  drawn = splat.negative != kNotDrawn;
  if (!drawn || !load_gaussian<form>(a.set, n, at_rest)) return sums;
  const GaussianState<float>& g = state_in_view<form>(a.set, n, splat.view, at_rest, room);
  const ViewArgs<float>& view = a.views[splat.view];
  const ColourRules<float> colours = rules_of<form>(a.colours);
  const Slice<float> slice = slice_in_view(view, g, a.rules.time_filter);
  const Vec3<float> time_slope = colours.levels > 0 ? a.time_slopes[s] : Vec3<float>(0.0f);
  const auto add_to = [&](ViewSums<float>& of_view) {
    add_view_gradient(
        view, g, slice, a.slopes[s], time_slope, colours, a.rules, splat, a.d_splats[s],
        a.statistics.length_share > 0 ? a.statistics.length_share * a.lengths[s] : 0.0f, of_view);
  };
  if constexpr (form == SetForm::kCanonical) {
    const int64_t place = splat.view * a.set.carried_stride + n;
    ViewSums<float> of_view;
    add_to(of_view);
    a.d_carried[place] = carried_gradient(a.set.carried[place], g, of_view, sums);
  } else {
    add_to(sums);
    if (is_dynamic(form) && a.d_times != nullptr)
      by_time = time_gradient(view, g, slice, colours, time_slope, splat, a.d_splats[s],
                              sums.spacetime.mean_time);
  }
  return sums;
}

/// Adds what the splats of a warp found by the times of their views, one a thread; 0 of no splat.
__device__ inline void add_times(const Backward& a, int view, const TimeGradient<float>& d) {
  for (int i = 0; i < 2 * a.view_count; ++i) {
    const bool is_readout = i >= a.view_count;
    const float value = is_readout ? d.readout : d.time;
    const bool taken = view == (is_readout ? i - a.view_count : i);
    long long sum = taken ? __double2ll_rn(double(value) * kTimeSteps) : 0;
    for (int offset = 16; offset > 0; offset /= 2)
      sum += __shfl_down_sync(0xffffffffu, sum, offset);
    if (threadIdx.x % 32 == 0 && sum != 0)
      atomicAdd(reinterpret_cast<unsigned long long*>(a.d_times + i), (unsigned long long)(sum));
  }
}

/// Of the splats [begin, end) of this thread's Gaussian, those of the block's threads; the splat of
/// thread 0 is s.
template <SetForm form>
__device__ inline void add_shared(const Shared<form>& shared, int64_t s, int64_t begin, int64_t end,
                                  SumsOf<form, float>& sums, int& seen) {
  float* const to = reinterpret_cast<float*>(&sums);
  const int last = int(min(end - s, int64_t{kThreads}));
  for (int i = int(max(begin - s, int64_t{0})); i < last; ++i) {
    seen += shared.drawn[i];
    TESSERA_UNROLL
    for (int k = 0; k < kSumFloats<form>; ++k) to[k] += shared.sums[k][i];
  }
}

/// Prefetches the moments of a block's Gaussians, which are read last.
template <SetForm form>
__device__ inline void prefetch_moments(const StoreGradient<float>&, int64_t) {}
template <SetForm form>
__device__ inline void prefetch_moments(const ApplyAdam<float>& sink, int64_t count) {
  constexpr int kLine = 32;  // floats
  const int64_t first = int64_t(blockIdx.x) * kThreads;
  const int gaussians = int(min(count - first, int64_t{kThreads}));
  const GeometryGradient<float> any;
  GeometryGradient<float>::for_each_group<form>(any, [&](Group group, const float*, int width) {
    const int i = int(threadIdx.x) * kLine;
    if (i >= gaussians * width) return;
    for (const GaussianSpans<float>* moment : {&sink.moment1, &sink.moment2})
      asm volatile("prefetch.global.L2 [%0];" ::"l"(moment->group[group].data + first * width + i));
  });
}

/// One block for kThreads Gaussians: what their splats found, through their stored parameters, into
/// the sink.
template <SetForm form, class Sink>
__global__ void __launch_bounds__(kThreads, kBlocks) geometry_backward(Backward a, Sink sink) {
  __shared__ union {
    Shared<form> splats;
    float gradients[geometry_scalars(form) * kThreads];  // of a canonical set fewer are used
  } shared;
  __shared__ bool stepping[kThreads];
  const int64_t first = int64_t(blockIdx.x) * kThreads, n = first + threadIdx.x;
  const int64_t block_begin = a.first_of[a.first + first];
  const int64_t block_end = a.first_of[a.first + min(first + kThreads, a.set.count)];
  if (block_begin == block_end && a.idle == IdleUpdate::kSkip) return;
  prefetch_moments<form>(sink, a.set.count);
  const bool listed = n < a.set.count;
  const int64_t begin = listed ? a.first_of[a.first + n] : 0;
  const int64_t end = listed ? a.first_of[a.first + n + 1] : 0;
  SumsOf<form, float> sums;
  int seen = 0;
  for (int64_t s = block_begin; s < block_end; s += kThreads) {
    const int64_t taken = s + threadIdx.x;
    bool drawn = false;
    TimeGradient<float> by_time;
    const SumsOf<form, float> found =
        taken < block_end ? splat_sums<form>(a, taken, drawn, by_time) : SumsOf<form, float>();
    TESSERA_UNROLL
    for (int k = 0; k < kSumFloats<form>; ++k)
      shared.splats.sums[k][threadIdx.x] = reinterpret_cast<const float*>(&found)[k];
    shared.splats.drawn[threadIdx.x] = drawn;
    if constexpr (is_dynamic(form))
      if (a.d_times != nullptr) add_times(a, drawn ? a.splats[taken].view : 0, by_time);
    __syncthreads();
    add_shared<form>(shared.splats, s, begin, end, sums, seen);
    __syncthreads();
  }
  GeometryGradient<float> gradient;
  GaussianState<float> g;
  if (begin < end && load_gaussian<form>(a.set, n, g)) {
    gradient = geometry_gradient<form>(a.set, n, g, sums);
    if (seen > 0 && !a.statistics.count.empty()) {
      a.statistics.gradient_sum[n] += mean_view_norm(sums.ndc_norms, a.view_count, seen);
      a.statistics.count[n] += 1.0f;
    }
  }
  const bool on = listed && (begin < end || a.idle != IdleUpdate::kSkip);
  if (on) {
    add_regulariser<form>(a.regulariser, a.set, n, float(seen) / float(a.view_count), gradient);
    const unsigned bad = non_finite_groups<form>(gradient);
    if (bad != 0) atomicOr(&a.counters->bad_groups, bad);
  }
  accept_block<form, kThreads>(sink, a.set.count, on, gradient, shared.gradients, stepping);
}

/// Neighbouring SH scalars of a Gaussian: one access of 16 bytes where there are 4.
template <int Scalars>
struct alignas(4 * Scalars) ShScalars {
  float value[Scalars];
};

/// What a sink has of them before their gradient is known.
template <class Sink, int Scalars>
struct ShState {};
template <int Scalars>
struct ShState<ApplyAdam<float>, Scalars> {
  ShScalars<Scalars> value, moments;
};

template <Group group, int Scalars>
__device__ inline void load_state(const StoreGradient<float>&, int64_t, int,
                                  ShState<StoreGradient<float>, Scalars>&) {}
template <Group group, int Scalars>
__device__ inline void load_state(const ApplyAdam<float>& sink, int64_t n, int first,
                                  ShState<ApplyAdam<float>, Scalars>& state) {
  using Access = const ShScalars<Scalars>&;
  state = {reinterpret_cast<Access>(sink.value.at(group, n)[first]),
           reinterpret_cast<Access>(sink.moment1.at(group, n)[first])};
}

template <Group group, int Scalars>
__device__ inline void accept_sh(const StoreGradient<float>& sink, int64_t n, int first,
                                 const float (&g)[Scalars],
                                 ShState<StoreGradient<float>, Scalars>&) {
  for (int j = 0; j < Scalars; ++j) sink.accept_sh(group, n, first + j, g[j]);
}
template <Group group, int Scalars>
__device__ inline void accept_sh(const ApplyAdam<float>& sink, int64_t n, int first,
                                 const float (&g)[Scalars],
                                 ShState<ApplyAdam<float>, Scalars>& state) {
  auto& [x, moments] = state;
  TESSERA_UNROLL
  for (int j = 0; j < Scalars; ++j)
    adam_step_packed(sink.sh_scalars(group, first + j), g[j], x.value[j], moments.value[j]);
  using Access = ShScalars<Scalars>&;
  reinterpret_cast<Access>(sink.value.at(group, n)[first]) = x;
  reinterpret_cast<Access>(sink.moment1.at(group, n)[first]) = moments;
}

/// What the SH of a Gaussian get from one splat of it.
struct ShSplat {
  float basis[kMaxShCoefficients];
  float d_colour[3];
  float time;  // of its view
};
constexpr int kShSplats = 64;  // in shared memory at a time

__device__ inline void load_sh_splat(const Backward& a, int64_t s, ShSplat& out) {
  const Splat<float>& splat = a.splats[s];
  const Vec3<float> d_colour = unclamped_gradient(splat.negative, a.d_splats[s].colour);
  const bool drawn = splat.negative != kNotDrawn;
  for (int c = 0; c < 3; ++c) out.d_colour[c] = drawn ? d_colour[c] : 0.0f;
  float Y[kMaxShCoefficients] = {};
  if (drawn) sh_basis(a.colours.degree, a.slopes[s].direction, Y);
  TESSERA_UNROLL
  for (int k = 0; k < kMaxShCoefficients; ++k) out.basis[k] = Y[k];
  out.time = a.views[splat.view].time;
}

/// A block has a few Gaussians (y), whose threads (x) have `Scalars` neighbouring ones of the
/// coefficients each, all of one level of time: 4 where elements allow it. The basis is found once
/// for each splat.
template <Group group, int Scalars, class Sink>
__global__ void __launch_bounds__(kShThreads) sh_backward(Backward a, Sink sink, bool stores) {
  __shared__ ShSplat splats[kShSplats];
  const int64_t block_first = int64_t(blockIdx.x) * blockDim.y, n = block_first + threadIdx.y;
  const bool listed = n < a.set.count;
  const int64_t block_begin = a.first_of[a.first + block_first];
  const int64_t block_end = a.first_of[a.first + min(block_first + blockDim.y, a.set.count)];
  if (block_begin == block_end && a.idle != IdleUpdate::kDense) return;
  const int thread = int(threadIdx.y * blockDim.x + threadIdx.x);
  const int first = int(threadIdx.x) * Scalars;
  const int level = group == kShTime ? 1 + first / a.colours.row : 0;
  const int in_level = group == kShTime ? first - (level - 1) * a.colours.row : first;
  const int64_t begin = listed ? a.first_of[a.first + n] : 0;
  const int64_t end = listed ? a.first_of[a.first + n + 1] : 0;
  // coefficients of bands and levels that are not active yet have neither gradient nor moments
  const bool active =
      listed && in_level / 3 < sh_coefficients(a.colours.degree) && level <= a.colours.levels;
  const bool on = (begin < end || (listed && a.idle == IdleUpdate::kDense)) && (active || stores);
  ShState<Sink, Scalars> state;  // on its way while the splats are
  if (on) load_state<group>(sink, n, first, state);
  const float mean_time = group == kShTime && active ? *a.set.at(kMeanTime, n) : 0.0f;
  float sum[Scalars] = {};
  for (int64_t s = block_begin; s < block_end; s += kShSplats) {
    if (thread < kShSplats && s + thread < block_end) load_sh_splat(a, s + thread, splats[thread]);
    __syncthreads();
    const int last = int(min(end - s, int64_t{kShSplats}));
    for (int i = int(max(begin - s, int64_t{0})); active && i < last; ++i) {
      const ShSplat& splat = splats[i];
      const float weight =
          group == kShTime ? level_weight(a.colours, level, splat.time - mean_time) : 1.0f;
      TESSERA_UNROLL
      for (int j = 0; j < Scalars; ++j)
        sum[j] += sh_gradient(splat.basis[(in_level + j) / 3], weight,
                              splat.d_colour[(in_level + j) % 3]);
    }
    __syncthreads();
  }
  if (!on) return;
  float check = 0;
  for (int j = 0; j < Scalars; ++j) check += sum[j] - sum[j];
  if (!(check == 0.0f)) atomicOr(&a.counters->bad_groups, 1u << group);
  accept_sh<group>(sink, n, first, sum, state);
}

template <Group group, class Sink>
void backward_sh(const Backward& a, const Sink& sink, bool stores, cudaStream_t stream) {
  const bool fours = a.colours.row % 4 == 0;
  const unsigned threads = unsigned(a.set.width(group) / (fours ? 4 : 1));  // of a Gaussian
  if (threads == 0) return;
  const dim3 block(threads, kShThreads / threads);
  const auto kernel = fours ? sh_backward<group, 4, Sink> : sh_backward<group, 1, Sink>;
  kernel<<<grid_of(a.set.count, int(block.y)), block, 0, stream>>>(a, sink, stores);
  check_launch("project_backward: sh_backward");
}

template <class Sink>
Sink sink_of(const SinkArgs<float>& args) {
  if constexpr (std::is_same_v<Sink, ApplyAdam<float>>)
    return {args.value, args.moment1, args.moment2, args.adam};
  else
    return {args.gradient};
}

template <SetForm form, class Sink>
void backward_set(const Backward& all, const RenderOptions& options, const SinkArgs<float>& args,
                  cudaStream_t stream) {
  const GaussianSpans<const float>& set = all.set;
  for_each_block(set.blocks, set.count, set.coefficients, [&](const ShBlock& elements) {
    Backward a = all;
    a.set = set.block(elements);
    a.first = all.first + elements.first;
    a.colours = make_colour_rules<float>(options, a.set.coefficients, a.set.time_levels);
    a.statistics = all.statistics.block(elements);
    a.d_carried = all.d_carried + elements.first;
    const Sink sink = sink_of<Sink>(args.block(elements));
    backward_sh<kSh>(a, sink, !args.fused, stream);
    if constexpr (is_dynamic(form)) backward_sh<kShTime>(a, sink, !args.fused, stream);
    // last: a fused optimizer changes the means in time that the SH of time read
    geometry_backward<form, Sink><<<grid_of(a.set.count, kThreads), kThreads, 0, stream>>>(a, sink);
    check_launch("project_backward: geometry_backward");
  });
}

}  // namespace

void CudaBackend::project_backward(const ProjectBackwardArgs<float>& args) {
  int64_t first = 0;
  check(args.splats->slope.size() == args.splats->count,
        "project_backward after a forward pass that was not for it");
  const RegulariserTerms<float> terms(args.regulariser,
                                      args.forward.sets[0].count + args.forward.sets[1].count);
  if (!args.d_carried.empty())  // of what no view draws
    check_device(
        cudaMemsetAsync(args.d_carried.data, 0,
                        size_t(args.d_carried.size) * sizeof(CarriedGaussian<float>), stream_),
        "memset");
  time_sums_.resize(args.by_time ? int64_t(2 * args.forward.batch->views.size()) : 0);
  if (args.by_time)
    check_device(cudaMemsetAsync(time_sums_.data(), 0,
                                 size_t(time_sums_.size()) * sizeof(*time_sums_.data()), stream_),
                 "memset");
  double bytes = double(args.splats->count) * (2 * (48 + 36 + 48) + 4);
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
                     args.splats->slope.data(),
                     args.splats->time_slope.data(),
                     args.splats->gaussian.data(),
                     args.splats->first_of.data(),
                     args.d_splats.data,
                     args.lengths.data,
                     args.statistics[set],
                     sink.fused ? sink.idle : IdleUpdate::kDense,
                     terms,
                     counters_.data(),
                     args.d_carried.data,
                     args.by_time ? time_sums_.data() : nullptr};
    with_drawn_form(spans.form, [&](auto form) {
      const auto run = sink.fused ? backward_set<form(), ApplyAdam<float>>
                                  : backward_set<form(), StoreGradient<float>>;
      run(a, args.forward.options, sink, stream_);
    });
    first += spans.count;
    const double geometry = double(spans.count) * geometry_scalars(spans.form);
    const double sh = double(spans.group[kSh].size + spans.group[kShTime].size);
    bytes +=
        8 * double(spans.count) + geometry * (sink.fused ? 24 : 8) + sh * (sink.fused ? 16 : 8);
  }
  report();
  clock_.add_bytes(kProjectBackward, bytes);
}

}  // namespace tessera
