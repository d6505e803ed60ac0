// What: splat gradients → parameter gradients of each Gaussian, summed over its views, into a sink.
// Not: equations (math/). One task owns a run of Gaussians; parameters are read once.
// Source: method A.12, D.2, D.6.
#include <atomic>

#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/math/splat.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 512;  // Gaussians per task

/// Sums over the views of one Gaussian.
template <class Real>
struct ViewSums {
  SpacetimeGradient<Real> spacetime{};
  Vec3<Real> mean{};
  Real opacity{};    // by σ(logit)
  Real ndc_norms{};  // Σ_v ‖dL/d mean2D in NDC‖
};

template <class Real>
void add_view(const ViewArgs<Real>& view, const GaussianState<Real>& g, int degree,
              uint8_t negative, const Sym2<Real>& conic, const SplatGradient<Real>& d, Real* d_sh,
              ViewSums<Real>& sums) {
  const Slice<Real> slice = slice_at(g.mean, g.spacetime, view.time);
  Vec3<Real> d_sliced_mean(Real(0));
  project_ewa_backward(view, to_camera(view, slice.mean), g.spacetime.covariance, conic, d.mean2d,
                       d.conic, d_sliced_mean, sums.spacetime.covariance);
  Vec3<Real> d_colour = d.colour;
  for (int c = 0; c < 3; ++c)
    if (negative >> c & 1) d_colour[c] = Real(0);
  Real distance;
  const Vec3<Real> direction = view_direction(view, slice.mean, distance);
  d_sliced_mean += sh_colour_backward(degree, direction, distance, g.sh, d_colour, d_sh);
  slice_backward(g.spacetime, slice, d_sliced_mean, d.opacity * g.opacity, sums.spacetime);
  sums.mean += d_sliced_mean;
  sums.opacity += d.opacity * slice.marginal;
  const Real ndc_x = d.mean2d[0] * Real(view.width) * Real(0.5);
  const Real ndc_y = d.mean2d[1] * Real(view.height) * Real(0.5);
  sums.ndc_norms += sqrt(ndc_x * ndc_x + ndc_y * ndc_y);
}

template <int Dim, class Real>
void finish(const GaussianSpans<const Real>& set, int64_t n, const GaussianState<Real>& g,
            const ViewSums<Real>& sums, ParameterGradient<Real>& out) {
  const Vec4<Real> q = load4(set.at(kRotation, n));
  const Vec3<Real> log_scale = load3(set.at(kLogScale, n));
  out.mean = sums.mean;
  out.opacity_logit = sums.opacity * g.opacity * (Real(1) - g.opacity);
  if constexpr (Dim == 4) {
    const PairGradient<Real> d = pair_backward(q, load4(set.at(kRotationRight, n)), log_scale,
                                               *set.at(kLogScaleTime, n), sums.spacetime);
    out.rotation = d.rotation_left, out.rotation_right = d.rotation_right;
    out.log_scale = d.log_scale, out.log_scale_time = d.log_scale_time;
    out.mean_time = sums.spacetime.mean_time;
  } else {
    covariance3_backward(q, log_scale, sums.spacetime.covariance, out.rotation, out.log_scale);
  }
}

/// Bit (1 << group) for each group with a non-finite gradient.
template <int Dim, class Real>
unsigned non_finite(const ParameterGradient<Real>& gradient, int coefficients) {
  unsigned bits = 0;
  ParameterGradient<Real>::template for_each_group<Dim>(gradient, coefficients,
                                                        [&](Group group, const Real* g, int width) {
                                                          Real sum = Real(0);
                                                          for (int j = 0; j < width; ++j)
                                                            sum += g[j] - g[j];
                                                          if (!(sum == Real(0)))
                                                            bits |= 1u << group;
                                                        });
  return bits;
}

template <int Dim, class Sink, class Real>
unsigned backward_run(const ProjectBackwardArgs<Real>& args, int set, int64_t first_gaussian,
                      int64_t begin, int64_t end, const Sink& sink) {
  const GaussianSpans<const Real>& params = args.forward.sets[set];
  const DensityStatistics<Real>& statistics = args.statistics[set];
  const std::vector<ViewArgs<Real>>& views = args.forward.batch->views;
  const Splats<Real>& splats = *args.splats;
  const int degree = min_of(args.forward.options.sh_degree, sh_degree_of(params.coefficients));
  unsigned bad = 0;
  for (int64_t n = begin; n < end; ++n) {
    const int64_t first = splats.first_of[first_gaussian + n];
    const int64_t last = splats.first_of[first_gaussian + n + 1];
    ParameterGradient<Real> gradient;
    GaussianState<Real> g;
    if (first < last && load_gaussian<Dim>(params, n, g)) {
      ViewSums<Real> sums;
      for (int64_t s = first; s < last; ++s)
        add_view(views[size_t(splats.view[s])], g, degree, splats.negative[s], splats.conic[s],
                 args.d_splats[s], gradient.sh, sums);
      finish<Dim>(params, n, g, sums, gradient);
      bad |= non_finite<Dim>(gradient, params.coefficients);
      if (!statistics.count.empty()) {
        // per-image gradients: the batch loss is their mean, so multiply by B, divide by n_v
        statistics.gradient_sum[n] += sums.ndc_norms * Real(views.size()) / Real(last - first);
        statistics.count[n] += Real(1);
      }
    }
    sink.template accept<Dim>(n, gradient);
  }
  return bad;
}

template <int Dim, class Real>
unsigned backward_set(const ProjectBackwardArgs<Real>& args, int set, int64_t first_gaussian) {
  const SinkArgs<Real>& sink = args.sinks[set];
  std::atomic<unsigned> bad{0};
  const auto run = [&](const auto& chosen) {
    parallel_for(args.forward.sets[set].count, kGrain, [&](int64_t begin, int64_t end) {
      bad |= backward_run<Dim>(args, set, first_gaussian, begin, end, chosen);
    });
  };
  if (sink.fused)
    run(ApplyAdam<Real>{sink.value, sink.moment1, sink.moment2, sink.adam});
  else
    run(StoreGradient<Real>{sink.gradient});
  return bad;
}

}  // namespace

template <class Real>
unsigned CpuBackend<Real>::project_backward(const ProjectBackwardArgs<Real>& args) {
  unsigned bad = 0;
  int64_t first_gaussian = 0;
  for (int set = 0; set < 2; ++set) {
    bad |= args.forward.sets[set].dim == 4 ? backward_set<4>(args, set, first_gaussian)
                                           : backward_set<3>(args, set, first_gaussian);
    first_gaussian += args.forward.sets[set].count;
  }
  return bad;
}

template unsigned CpuBackend<float>::project_backward(const ProjectBackwardArgs<float>&);
template unsigned CpuBackend<double>::project_backward(const ProjectBackwardArgs<double>&);

}  // namespace tessera
