// Shapes of dynamic Gaussians by eigen-decomposition, and the copy of those that are drawn at a
// timestep, with the colours of that timestep. The cut-offs are those of the renderer: both call
// load_gaussian and slice_at.
#include "static3d/transform/slicer.h"

#include <algorithm>
#include <iterator>

#include "kernels/base/parallel.h"
#include "kernels/load_gaussian.h"
#include "kernels/math/eigen3.h"
#include "recon4d/evaluation/render.h"

namespace tessera {
namespace {

constexpr float kMaxLogit = 88;  // σ is 1 in float long before; e⁸⁸ is still finite there

void set_shape(const Sym3<float>& covariance, MovingGaussian& g) {
  const Shape3 shape = shape_of(Sym3<double>{covariance.xx, covariance.xy, covariance.xz,
                                             covariance.yy, covariance.yz, covariance.zz});
  g.log_scale = Vec3<float>(shape.log_scale);
  g.rotation = Vec4<float>(shape.rotation);
}

/// logit(o·p) = ln(o·p) − ln(1 − o·p); 1 − o·p = (1 − o) + o·(1 − p) keeps its digits as o·p → 1.
float logit_of_product(double logit, double exponent) {
  const double o = 1 / (1 + std::exp(-logit)), one_minus_o = 1 / (1 + std::exp(logit));
  const double product = o * std::exp(exponent);
  const double rest = one_minus_o - o * std::expm1(exponent);
  return std::min(float(std::log(product) - std::log(rest)), kMaxLogit);
}

/// Whether the renderer draws it at t, by its own arithmetic.
bool is_drawn(const MovingGaussian& g, float time, float time_filter, const Cutoff<float>& cutoff,
              Slice<float>& slice) {
  slice = slice_at(g.mean, g.spacetime, time, time_filter);
  return slice.marginal >= kMinMarginal<float> && cutoff.keeps(g.opacity * slice.marginal);
}

void copy_sh(const float* from, int from_coefficients, float* to, int to_coefficients) {
  std::fill_n(std::copy_n(from, 3 * from_coefficients, to),
              3 * (to_coefficients - from_coefficients), 0.0f);
}

/// Means and rotations of a canonical set as its nodes carry them at a time.
void carry_to(double time, const GaussianSet& from, const MotionNodes& nodes, GaussianSet& to) {
  const std::unique_ptr<Backend> host = make_cpu_backend();
  const ViewBatch<float> batch = make_view_batch<float>({{Camera{}, time}});
  Carried<float> carried;
  host->carry({&batch, from.values(), nodes.spans()}, carried);
  const GaussianSpans<float> target = to.values();
  for (int64_t n = 0; n < from.count(); ++n) {
    const CarriedGaussian<float>& g = carried.gaussians[n];
    for (int c = 0; c < 3; ++c) target.at(kMean, n)[c] = g.mean[c];
    for (int c = 0; c < 4; ++c) target.at(kRotation, n)[c] = g.rotation[c];
  }
}

void copy_static(const GaussianSet& from, GaussianSet& to) {
  const GaussianSpans<const float> source = from.values();
  const GaussianSpans<float> target = to.values();
  for (Group g : {kMean, kLogScale, kRotation, kOpacityLogit})
    std::copy_n(source.group[g].data, source.group[g].size, target.group[g].data);
  for (int64_t n = 0; n < from.count(); ++n)
    copy_sh(source.at(kSh, n), from.coefficients(), target.at(kSh, n), to.coefficients());
}

}  // namespace

Slicer::Slicer(const GaussianModel& model) : model_(model) {
  constexpr int64_t kGrain = 4096;
  const GaussianSpans<const float> set = model.dynamic_set.values();
  std::vector<MovingGaussian> all(static_cast<size_t>(set.count));
  parallel_for(set.count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      MovingGaussian& g = all[size_t(n)];
      GaussianState<float> state;
      g.source = -1;
      if (!with_form(set.form, [&](auto form) { return load_gaussian<form()>(set, n, state); }))
        continue;
      g.source = n;
      g.spacetime = state.spacetime;
      g.mean = state.mean;
      g.opacity = state.opacity;
      set_shape(g.spacetime.covariance, g);
    }
  });
  std::copy_if(all.begin(), all.end(), std::back_inserter(moving_),
               [](const MovingGaussian& g) { return g.source >= 0; });
}

GaussianSet Slicer::at(double time) const {
  const GaussianSet &fixed = model_.static_set, &dynamic = model_.dynamic_set;
  std::vector<std::pair<const MovingGaussian*, Slice<float>>> drawn;
  Slice<float> slice;
  const Cutoff<float> cutoff = model_.cutoff<float>();
  for (const MovingGaussian& g : moving_)
    if (is_drawn(g, float(time), float(model_.drawing.time_filter), cutoff, slice))
      drawn.emplace_back(&g, slice);

  const auto stored = [](const GaussianSet& s) { return s.count() > 0 ? s.coefficients() : 1; };
  const int coefficients = std::max(stored(fixed), stored(dynamic));
  GaussianSet set(SetForm::kStatic, coefficients);
  set.resize(fixed.count() + int64_t(drawn.size()));
  copy_static(fixed, set);
  if (!model_.nodes.empty()) carry_to(time, fixed, model_.nodes, set);
  const GaussianSpans<const float> source = dynamic.values();
  const GaussianSpans<float> target = set.values();
  const ColourRules<float> colours =
      make_colour_rules<float>(render_options(model_), source.coefficients, source.time_levels);
  int64_t n = fixed.count();
  for (const auto& [g, at_time] : drawn) {
    const double precision = double(g->spacetime.precision_time) * double(at_time.kept);
    const double exponent = -0.5 * double(at_time.delta) * double(at_time.delta) * precision;
    for (int k = 0; k < 3; ++k) {
      target.at(kMean, n)[k] = at_time.mean[k];
      target.at(kLogScale, n)[k] = g->log_scale[k];
    }
    for (int k = 0; k < 4; ++k) target.at(kRotation, n)[k] = g->rotation[k];
    *target.at(kOpacityLogit, n) =
        logit_of_product(double(*source.at(kOpacityLogit, g->source)), exponent);
    copy_sh(source.at(kSh, g->source), dynamic.coefficients(), target.at(kSh, n), coefficients);
    add_levels(colours, at_time.delta, source.at(kShTime, g->source), target.at(kSh, n));
    ++n;
  }
  return set;
}

}  // namespace tessera
