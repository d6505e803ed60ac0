// Splat gradients to parameter gradients of each Gaussian on the CPU, summed over its views, into a
// sink. One task has a run of Gaussians, and parameters are read once. Source: method A.12, A.16,
// D.6.
#include <algorithm>
#include <atomic>
#include <utility>

#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/load_gaussian.h"
#include "kernels/stages/splat_gradient.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 512;  // Gaussians per task

/// Gradient by the parameters of one Gaussian.
template <class Real>
struct GaussianGradient {
  GeometryGradient<Real> geometry;
  Real sh[3 * kMaxShCoefficients] = {};
  Real sh_time[3 * kMaxShCoefficients * kMaxTimeLevels];  // of the levels that are stored
  unsigned bad = 0;
};

template <class Real>
void add_sh(const ColourRules<Real>& rules, const Vec3<Real>& direction, Real delta,
            const Vec3<Real>& d_colour, GaussianGradient<Real>& out) {
  Real Y[kMaxShCoefficients];
  sh_basis(rules.degree, direction, Y);
  for (int n = 0; n <= rules.levels; ++n) {
    const Real weight = n == 0 ? Real(1) : level_weight(rules, n, delta);
    Real* const d_level = n == 0 ? out.sh : out.sh_time + (n - 1) * rules.row;
    for (int k = 0; k < sh_coefficients(rules.degree); ++k)
      for (int c = 0; c < 3; ++c) d_level[3 * k + c] += sh_gradient(Y[k], weight, d_colour[c]);
  }
}

/// Whether all of `count` scalars are finite.
template <class Real>
bool all_finite(const Real* scalars, int count) {
  Real sum = Real(0);
  for (int j = 0; j < count; ++j) sum += scalars[j] - scalars[j];
  return sum == Real(0);
}

/// A block of a set, and how many Gaussians of both sets come before it.
template <class Real>
struct BlockArgs {
  GaussianSpans<const Real> set;
  int64_t first_gaussian;
  SinkArgs<Real> sink;
  DensityStatistics<Real> statistics;
  CarriedGaussian<Real>* d_carried;  // of a canonical set: [B, set.carried_stride]
  double* d_times;  // [2B] added to, of a dynamic set, times and readouts; null: not asked for
};

/// Element n of a block, whose splats are `first` … `last`.
template <SetForm form, class Real>
void gaussian_gradient(const ProjectBackwardArgs<Real>& args, const BlockArgs<Real>& block,
                       const SplatRules<Real>& rules, const ColourRules<Real>& colours, int64_t n,
                       int64_t first, int64_t last, double* d_times, GaussianGradient<Real>& out) {
  const GaussianSpans<const Real>& params = block.set;
  const std::vector<ViewArgs<Real>>& views = args.forward.batch->views;
  GaussianState<Real> at_rest, room_of_state;
  if (!load_gaussian<form>(params, n, at_rest)) return;
  SumsOf<form, Real> sums;
  for (int64_t s = first; s < last; ++s) {
    const Splat<Real>& splat = args.splats->splat[s];
    const ViewArgs<Real>& view = views[size_t(splat.view)];
    const SplatMoments<Real>& moments = args.d_splats[s];
    const Real share = block.statistics.length_share;
    const Real length = share > Real(0) ? share * args.lengths[s] : Real(0);
    const GaussianState<Real>& g =
        state_in_view<form>(params, n, splat.view, at_rest, room_of_state);
    const Slice<Real> slice = slice_in_view(view, g, rules.time_filter);
    Real room[3 * kMaxShCoefficients];
    const Real* const sh = sh_at(colours, g, colour_delta(view, g), room);
    Real distance;
    const Vec3<Real> direction =
        view_direction(view, colours.sliced_direction ? slice.mean : g.mean, distance);
    const ColourSlope<Real> slope = colour_slope(colours.degree, direction, distance, sh);
    const Vec3<Real> time_slope =
        colours.levels > 0 ? levels_slope(colours, colour_delta(view, g), g.sh_time, direction)
                           : Vec3<Real>(Real(0));
    if constexpr (form == SetForm::kCanonical) {
      const int64_t place = splat.view * params.carried_stride + n;
      ViewSums<Real> of_view;
      add_view_gradient(view, g, slice, slope, time_slope, colours, rules, splat, moments, length,
                        of_view);
      block.d_carried[place] = carried_gradient(params.carried[place], g, of_view, sums);
    } else {
      const Real before = sums.spacetime.mean_time;
      add_view_gradient(view, g, slice, slope, time_slope, colours, rules, splat, moments, length,
                        sums);
      if (d_times != nullptr) {
        const TimeGradient<Real> d = time_gradient(view, g, slice, colours, time_slope, splat,
                                                   moments, sums.spacetime.mean_time - before);
        d_times[splat.view] += double(d.time);
        d_times[views.size() + size_t(splat.view)] += double(d.readout);
      }
    }
    add_sh(colours, direction, colour_delta(view, g),
           unclamped_gradient(splat.negative, moments.colour), out);
  }
  out.geometry = geometry_gradient<form>(params, n, at_rest, sums);
  if (!all_finite(out.sh, params.width(kSh))) out.bad |= 1u << kSh;
  if (!all_finite(out.sh_time, params.width(kShTime))) out.bad |= 1u << kShTime;
  const DensityStatistics<Real>& statistics = block.statistics;
  if (statistics.count.empty()) return;
  statistics.gradient_sum[n] +=
      mean_view_norm(sums.ndc_norms, int(views.size()), int(last - first));
  statistics.count[n] += Real(1);
}

template <SetForm form, class Sink, class Real>
unsigned backward_run(const ProjectBackwardArgs<Real>& args, const BlockArgs<Real>& block,
                      const RegulariserTerms<Real>& terms, int64_t begin, int64_t end,
                      double* d_times, const Sink& sink) {
  const SinkArgs<Real>& wanted = block.sink;
  const IdleUpdate idle = wanted.fused ? wanted.idle : IdleUpdate::kDense;
  const GaussianSpans<const Real>& params = block.set;
  const SplatRules<Real> rules = make_splat_rules<Real>(args.forward.options);
  const ColourRules<Real> colours =
      make_colour_rules<Real>(args.forward.options, params.coefficients, params.time_levels);
  unsigned bad = 0;
  for (int64_t n = begin; n < end; ++n) {
    const int64_t first = args.splats->first_of[block.first_gaussian + n];
    const int64_t last = args.splats->first_of[block.first_gaussian + n + 1];
    if constexpr (form == SetForm::kCanonical)
      for (size_t b = 0; b < args.forward.batch->views.size(); ++b)
        block.d_carried[int64_t(b) * params.carried_stride + n] = {};
    if (first == last && idle == IdleUpdate::kSkip) continue;
    GaussianGradient<Real> gradient;
    std::fill_n(gradient.sh_time, params.width(kShTime), Real(0));
    if (first < last)
      gaussian_gradient<form>(args, block, rules, colours, n, first, last, d_times, gradient);
    const Real share = Real(last - first) / Real(args.forward.batch->views.size());
    add_regulariser<form>(terms, params, n, share, gradient.geometry);
    bad |= gradient.bad | non_finite_groups<form>(gradient.geometry);
    sink.template accept<form>(n, gradient.geometry);
    for (int j = 0; j < params.width(kSh); ++j) sink.accept_sh(kSh, n, j, gradient.sh[j]);
    for (int j = 0; j < params.width(kShTime); ++j)
      sink.accept_sh(kShTime, n, j, gradient.sh_time[j]);
  }
  return bad;
}

template <SetForm form, class Real>
unsigned backward_block(const ProjectBackwardArgs<Real>& args, const BlockArgs<Real>& block,
                        const RegulariserTerms<Real>& terms) {
  const SinkArgs<Real>& sink = block.sink;
  const bool by_time = is_dynamic(form) && block.d_times != nullptr;
  const auto sums = int64_t(2 * args.forward.batch->views.size());
  std::vector<double> d_times(by_time ? size_t((block.set.count / kGrain + 1) * sums) : 0);
  std::atomic<unsigned> bad{0};
  const auto run = [&](const auto& chosen) {
    parallel_for(block.set.count, kGrain, [&](int64_t begin, int64_t end) {
      bad |= backward_run<form>(args, block, terms, begin, end,
                                by_time ? d_times.data() + begin / kGrain * sums : nullptr, chosen);
    });
  };
  if (sink.fused)
    run(ApplyAdam<Real>{sink.value, sink.moment1, sink.moment2, sink.adam});
  else
    run(StoreGradient<Real>{sink.gradient});
  for (size_t i = 0; i < d_times.size(); ++i) block.d_times[i % size_t(sums)] += d_times[i];
  return bad;
}

}  // namespace

template <class Real>
void CpuBackend<Real>::project_backward(const ProjectBackwardArgs<Real>& args) {
  outcome_.bad_groups = 0;
  outcome_.bad_values = false;
  const size_t views = args.by_time ? args.forward.batch->views.size() : 0;
  std::vector<double> d_times(2 * views);
  const RegulariserTerms<Real> terms(args.regulariser,
                                     args.forward.sets[0].count + args.forward.sets[1].count);
  int64_t first_gaussian = 0;
  for (int set = 0; set < 2; ++set) {
    const GaussianSpans<const Real>& spans = args.forward.sets[set];
    for_each_block(spans.blocks, spans.count, spans.coefficients, [&](const ShBlock& elements) {
      const BlockArgs<Real> block{spans.block(elements),
                                  first_gaussian + elements.first,
                                  args.sinks[set].block(elements),
                                  args.statistics[set].block(elements),
                                  args.d_carried.data + elements.first,
                                  args.by_time ? d_times.data() : nullptr};
      outcome_.bad_groups |= with_drawn_form(
          spans.form, [&](auto form) { return backward_block<form()>(args, block, terms); });
    });
    first_gaussian += spans.count;
  }
  const auto of_readouts = d_times.begin() + std::ptrdiff_t(views);
  outcome_.d_times.assign(d_times.begin(), of_readouts);
  outcome_.d_readouts.assign(of_readouts, d_times.end());
}

template void CpuBackend<float>::project_backward(const ProjectBackwardArgs<float>&);
template void CpuBackend<double>::project_backward(const ProjectBackwardArgs<double>&);

}  // namespace tessera
