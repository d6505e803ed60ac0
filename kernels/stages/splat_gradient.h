// The gradient of one splat, its sum over the views of a Gaussian, and the gradient by the stored
// parameters, with the gradient of the regularisers, which depend on the parameters alone. Source:
// method A.12, B, C.1, C.2, D.2, D.3, D.6; regularisers: [3DGS-MCMC].
#pragma once
#include "kernels/batch.h"
#include "kernels/load_gaussian.h"
#include "kernels/math/ewa.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {

/// Sums over the views of one Gaussian.
template <class Real>
struct ViewSums {
  SpacetimeGradient<Real> spacetime{};
  Vec3<Real> mean{};
  Real opacity{};    // by the opacity before p and comp
  Real ndc_norms{};  // Σ_v growth_norm
};

/// dL/d(un-clamped colour) of a splat: 0 where the channel was clamped.
template <class Real>
TESSERA_HD inline Vec3<Real> unclamped_gradient(uint32_t negative, const Vec3<Real>& d_colour) {
  Vec3<Real> d;
  for (int c = 0; c < 3; ++c) d[c] = negative >> c & 1 ? Real(0) : d_colour[c];
  return d;
}

/// What a splat adds to the statistic of density control, in NDC: the length of its gradient by
/// pixels, or where it is larger `length`, of BlendBackwardArgs::lengths times length_share.
template <class Real>
TESSERA_HD inline Real growth_norm(const ViewArgs<Real>& view, const Splat<Real>& splat,
                                   const Vec2<Real>& d_mean2d, Real length) {
  return max_of(ndc_gradient_norm(d_mean2d, view.width, view.height),
                length * splat.opacity * Real(max_of(view.width, view.height)) * Real(0.5));
}

/// Adds one view of Gaussian g; `slice`, `slope`, `time_slope`: of it in that view (levels_slope;
/// not read where there are no levels); `moments`, `length` (growth_norm): of this splat.
template <class Real>
TESSERA_HD inline void add_view_gradient(const ViewArgs<Real>& view, const GaussianState<Real>& g,
                                         const Slice<Real>& slice, const ColourSlope<Real>& slope,
                                         const Vec3<Real>& time_slope,
                                         const ColourRules<Real>& colours,
                                         const SplatRules<Real>& rules, const Splat<Real>& splat,
                                         const SplatMoments<Real>& moments, Real length,
                                         ViewSums<Real>& sums) {
  const SplatGradient<Real> d = splat_gradient(splat.conic, splat.opacity, moments);
  // a constant of the gradient  [Faster-GS]
  const Real comp = rules.compensated ? compensation(splat.conic, rules.dilation) : Real(1);
  Vec3<Real> d_mean(Real(0));
  project_ewa_backward(view, to_camera(view, slice.mean), g.spacetime.covariance, splat.conic,
                       d.mean2d, d.conic, d_mean, sums.spacetime.covariance);
  const Vec3<Real> d_colour = unclamped_gradient(splat.negative, d.colour);
  const Vec3<Real> d_eye = slope.backward(d_colour);
  if (colours.sliced_direction) d_mean += d_eye;
  slice_backward(g.spacetime, slice, d_mean, d.opacity * comp * g.opacity, sums.spacetime);
  if (colours.levels > 0) sums.spacetime.mean_time += dot(time_slope, d_colour);
  sums.mean += colours.sliced_direction ? d_mean : d_mean + d_eye;
  sums.opacity += d.opacity * comp * slice.marginal;
  sums.ndc_norms += growth_norm(view, splat, d.mean2d, length);
}

/// What a splat adds to the gradients by the time and by the readout of its view.
template <class Real>
struct TimeGradient {
  Real time{}, readout{};
};

/// `d_mean_time`: what the splat added to SpacetimeGradient::mean_time, since a Gaussian knows a
/// time by its distance from the mean in time; its colour has no row.
template <class Real>
TESSERA_HD inline TimeGradient<Real> time_gradient(
    const ViewArgs<Real>& view, const GaussianState<Real>& g, const Slice<Real>& slice,
    const ColourRules<Real>& colours, const Vec3<Real>& time_slope, const Splat<Real>& splat,
    const SplatMoments<Real>& moments, Real d_mean_time) {
  Real of_colour = Real(0);
  if (colours.levels > 0)
    of_colour = dot(time_slope, unclamped_gradient(splat.negative, moments.colour));
  return {-d_mean_time,
          (of_colour - d_mean_time) * shown_row_share(view, g, slice, splat.mean2d[1])};
}

/// Sums over the views of one canonical Gaussian: of what does not pass through its nodes.
template <class Real>
struct CarriedSums {
  Vec3<Real> log_scale{};
  Real opacity_logit{};
  Real ndc_norms{};  // as ViewSums::ndc_norms
};
template <SetForm form, class Real>
using SumsOf = std::conditional_t<form == SetForm::kCanonical, CarriedSums<Real>, ViewSums<Real>>;

/// Of a canonical Gaussian g, which is `carried` in one view: gradient by what it is there, from
/// the sums of that view; what does not pass through its nodes is added to `sums`.
template <class Real>
TESSERA_HD inline CarriedGaussian<Real> carried_gradient(const CarriedGaussian<Real>& carried,
                                                         const GaussianState<Real>& g,
                                                         const ViewSums<Real>& of_view,
                                                         CarriedSums<Real>& sums) {
  CarriedGaussian<Real> d;
  Vec3<Real> d_log_scale;
  covariance3_backward(carried.rotation, g.log_scale, of_view.spacetime.covariance, d.rotation,
                       d_log_scale);
  d.mean = of_view.mean;
  sums.log_scale += d_log_scale;
  sums.opacity_logit += of_view.opacity * g.opacity * (Real(1) - g.stored_opacity);
  sums.ndc_norms += of_view.ndc_norms;
  return d;
}

/// Sums over the views → gradient by the stored parameters of Gaussian n.
template <SetForm form, class Real>
TESSERA_HD inline GeometryGradient<Real> geometry_gradient(const GaussianSpans<const Real>&,
                                                           int64_t, const GaussianState<Real>&,
                                                           const CarriedSums<Real>& sums) {
  static_assert(form == SetForm::kCanonical);
  GeometryGradient<Real> out;
  out.log_scale = sums.log_scale;
  out.opacity_logit = sums.opacity_logit;
  return out;
}
template <SetForm form, class Real>
TESSERA_HD inline GeometryGradient<Real> geometry_gradient(const GaussianSpans<const Real>& set,
                                                           int64_t n, const GaussianState<Real>& g,
                                                           const ViewSums<Real>& sums) {
  GeometryGradient<Real> out;
  const Vec4<Real> q = load4(set.at(kRotation, n));
  const Vec3<Real>& log_scale = g.log_scale;
  out.mean = sums.mean;
  out.opacity_logit = sums.opacity * g.opacity * (Real(1) - g.stored_opacity);
  if constexpr (form == SetForm::kPair) {
    const PairGradient<Real> d = pair_backward(q, load4(set.at(kRotationRight, n)), log_scale,
                                               *set.at(kLogScaleTime, n), sums.spacetime);
    out.rotation = d.rotation_left;
    out.rotation_right = d.rotation_right;
    out.log_scale = d.log_scale;
    out.log_scale_time = d.log_scale_time;
    out.mean_time = sums.spacetime.mean_time;
  } else {
    covariance3_backward(q, log_scale, sums.spacetime.covariance, out.rotation, out.log_scale);
  }
  if constexpr (form == SetForm::kVelocity) {
    out.velocity = sums.spacetime.velocity;
    out.log_scale_time = Real(-2) * sums.spacetime.precision_time * g.spacetime.precision_time;
    out.mean_time = sums.spacetime.mean_time;
  }
  if (!set.filter_size.empty())
    smooth_backward(log_scale, Real(set.filter_size[n]), sums.opacity * g.opacity, out.log_scale);
  return out;
}

/// RegulariserWeights by Gaussian: divided by what their means are over.
template <class Real>
struct RegulariserTerms {
  Real opacity, scale;

  /// `gaussians`: of both sets.
  RegulariserTerms(const RegulariserWeights& weights, int64_t gaussians)
      : opacity(Real(weights.opacity / double(max_of(gaussians, int64_t{1})))),
        scale(Real(weights.scale / (3 * double(max_of(gaussians, int64_t{1}))))) {}
};

/// Adds the terms in stored parameters of Gaussian n, which `share` of the batch's views draw. Of a
/// static Gaussian they are terms of a view's loss, as what the pixels add is: where no view draws
/// it, no image gives it a gradient, and Adam would make full steps of however small a gradient. A
/// dynamic Gaussian is drawn near its own time alone, however many cameras there are: it has them
/// in every step. Parameters are read for terms that there are.
// Deviation: [3DGS-MCMC] adds them to every Gaussian in every step; a static one that few of many
// views see then fades between those views.
template <SetForm form, class Real>
TESSERA_HD inline void add_regulariser(const RegulariserTerms<Real>& terms,
                                       const GaussianSpans<const Real>& set, int64_t n, Real share,
                                       GeometryGradient<Real>& gradient) {
  const Real weight = is_dynamic(form) ? Real(1) : share;
  if (weight == Real(0)) return;
  if (terms.opacity != Real(0)) {
    const Real o = sigmoid(*set.at(kOpacityLogit, n));
    gradient.opacity_logit += weight * terms.opacity * o * (Real(1) - o);
  }
  if (terms.scale != Real(0)) {
    const Vec3<Real> s = load3(set.at(kLogScale, n));
    for (int k = 0; k < 3; ++k) gradient.log_scale[k] += weight * terms.scale * exp(s[k]);
  }
}

}  // namespace tessera
