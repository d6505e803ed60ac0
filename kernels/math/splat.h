// What: one Gaussian in one view → one splat: slice, cull, project, colour, bounds. In that order.
// Not: loops and storage; both passes of every backend call these two functions.
// Source: method A.5, A.6, C.1–C.3, D.1.
#pragma once
#include "kernels/gaussians.h"
#include "kernels/math/filter_3d.h"
#include "kernels/math/spacetime.h"
#include "kernels/math/spherindrical.h"
#include "kernels/math/splat_rules.h"

namespace tessera {

/// What a view needs of a Gaussian, loaded and derived once per batch.
template <class Real>
struct GaussianState {
  Vec3<Real> mean;
  Real opacity;          // σ(logit), after the 3D filter
  Real stored_opacity;   // σ(logit)
  Vec3<Real> log_scale;  // after the 3D filter
  Spacetime<Real> spacetime;
  const Real* sh;
  const Real* sh_time;  // of the levels of time
};

template <class Real>
TESSERA_HD inline Vec3<Real> load3(const Real* p) {
  return Vec3<Real>(p[0], p[1], p[2]);
}
template <class Real>
TESSERA_HD inline Vec4<Real> load4(const Real* p) {
  return Vec4<Real>(p[0], p[1], p[2], p[3]);
}

/// False for a Gaussian that is no Gaussian: a quaternion of no length, a value not finite.
template <Form form, class Real>
TESSERA_HD inline bool load_gaussian(const GaussianSpans<const Real>& set, int64_t n,
                                     GaussianState<Real>& g) {
  const Vec4<Real> q = load4(set.at(kRotation, n));
  Vec3<Real> log_scale = load3(set.at(kLogScale, n));
  if (!(dot(q, q) >= kMinQuaternionNorm2<Real>)) return false;
  g.stored_opacity = g.opacity = sigmoid(*set.at(kOpacityLogit, n));
  if (!set.filter_size.empty()) {
    const Smoothed<Real> smoothed = smooth(log_scale, Real(set.filter_size[n]));
    log_scale = smoothed.log_scale;
    g.opacity *= smoothed.dimming;
  }
  g.log_scale = log_scale;
  if constexpr (form == Form::kPair) {
    const Vec4<Real> r = load4(set.at(kRotationRight, n));
    if (!(dot(r, r) >= kMinQuaternionNorm2<Real>)) return false;
    g.spacetime = pair_spacetime(q, r, log_scale, *set.at(kLogScaleTime, n), *set.at(kMeanTime, n));
  } else if constexpr (form == Form::kVelocity) {
    g.spacetime = velocity_spacetime(q, log_scale, load3(set.at(kVelocity, n)),
                                     *set.at(kLogScaleTime, n), *set.at(kMeanTime, n));
  } else {
    g.spacetime = static_spacetime(q, log_scale);
  }
  g.mean = load3(set.at(kMean, n));
  // of a set whose rows differ in K these lead nowhere: who needs colours has a block of it
  g.sh = set.group[kSh].data + n * set.width(kSh);
  g.sh_time = set.group[kShTime].data + n * set.width(kShTime);
  const Sym3<Real>& c = g.spacetime.covariance;
  const Real trace = c.xx + c.yy + c.zz;
  Real stored = g.mean[0] + g.mean[1] + g.mean[2] + *set.at(kOpacityLogit, n) + log_scale[0] +
                log_scale[1] + log_scale[2];
  if constexpr (form != Form::kStatic) stored += *set.at(kLogScaleTime, n);
  if constexpr (form == Form::kVelocity) {
    const Vec3<Real> v = g.spacetime.velocity;
    stored += v[0] + v[1] + v[2];
  }
  const Real sum = stored + trace + g.spacetime.mean_time + g.spacetime.precision_time;
  return sum - sum == Real(0);  // finite
}

/// φ of the 3D filter of Gaussian n from what each view that samples it sees; −1 where none does.
/// In 4D a view sees the mean at its own moment, if the Gaussian is drawn then at all.
template <Form form, class Real>
TESSERA_HD inline Real filter_size_in(const GaussianSpans<const Real>& set, int64_t n,
                                      const ViewArgs<Real>* views, int64_t view_count,
                                      Real near_plane, Real focal, Real time_filter) {
  GaussianState<Real> g;
  if (!load_gaussian<form>(set, n, g)) return Real(-1);
  Real least = Real(-1);
  for (int64_t b = 0; b < view_count; ++b) {
    const Slice<Real> slice = slice_at(g.mean, g.spacetime, views[b].time, time_filter);
    if (!(slice.marginal >= kMinMarginal<Real>)) continue;
    const Vec3<Real> in_cam = to_camera(views[b], slice.mean);
    if (!samples(views[b], in_cam, near_plane)) continue;
    least = least < Real(0) ? in_cam[2] : min_of(least, in_cam[2]);
  }
  return least < Real(0) ? least : sqrt(kFilterVariance<Real>) * least / focal;
}

template <class Real>
struct ViewSplat {
  Slice<Real> slice;
  Projection<Real> projection;
  Real opacity;  // effective: o·p, with the 2D filter o·p·comp
  Real power;    // of the cut-off ellipse
  TileRect rect;

  TESSERA_HD Footprint<Real> footprint() const {
    return {projection.mean2d, projection.conic, power};
  }
};

/// Direction from the camera to the Gaussian, and its length.
/// Deviation: both reference codes take the unconditional mean μ [method 0.19], we the mean at the
/// view's moment: a frame exported as a static 3DGS file then renders equal to the 4D model. The
/// option sliced_direction restores theirs.
template <class Real>
TESSERA_HD inline Vec3<Real> view_direction(const ViewArgs<Real>& view, const Vec3<Real>& mean,
                                            Real& distance) {
  const Vec3<Real> offset = mean - view.position;
  distance = sqrt(dot(offset, offset));
  return offset * (Real(1) / distance);
}

/// False when the Gaussian is not drawn in this view.
template <class Real>
TESSERA_HD inline bool splat_in_view(const ViewArgs<Real>& view, const GaussianState<Real>& g,
                                     const SplatRules<Real>& rules, ViewSplat<Real>& out) {
  out.slice = slice_at(g.mean, g.spacetime, view.time, rules.time_filter);
  if (!(out.slice.marginal >= kMinMarginal<Real>)) return false;
  out.opacity = g.opacity * out.slice.marginal;
  if (!rules.cutoff.keeps(out.opacity)) return false;
  const Vec3<Real> in_cam = to_camera(view, out.slice.mean);
  if (!(in_cam[2] >= rules.near_plane && in_cam[2] <= rules.far_plane)) return false;
  if (!project_ewa(view, in_cam, g.spacetime.covariance, rules.dilation, out.projection))
    return false;
  const Real probe = out.projection.mean2d[0] + out.projection.mean2d[1] + out.projection.det;
  if (!(probe - probe == Real(0))) return false;  // overflowed
  if (rules.compensated) {
    out.opacity *= compensation(out.projection.conic, rules.dilation);
    if (!rules.cutoff.keeps(out.opacity)) return false;
  }
  out.power = bounds_power(rules.bounds, out.opacity, rules.cutoff);
  out.rect = tile_rect(rules.bounds, view, out.projection.mean2d, out.projection.cov2d, out.power);
  return !out.rect.empty();
}

/// The SH coefficients of g at a moment: those that are stored, or, where levels of time are added
/// to them, what they make in `room`, [3·kMaxShCoefficients].
template <class Real>
TESSERA_HD inline const Real* sh_at(const ColourRules<Real>& rules, const GaussianState<Real>& g,
                                    Real delta, Real* room) {
  if (rules.levels == 0) return g.sh;
  for (int j = 0; j < rules.scalars(); ++j) room[j] = g.sh[j];
  add_levels(rules, delta, g.sh_time, room);
  return room;
}

/// Drawn colour in a viewing direction, clamped at 0; bit c of `negative`: channel c was. False
/// when it is not finite.
template <class Real>
TESSERA_HD inline bool drawn_colour(int degree, const Vec3<Real>& direction, const Real* sh,
                                    Vec3<Real>& drawn, uint32_t& negative) {
  const Vec3<Real> colour = sh_colour(degree, direction, sh);
  const Real sum = colour[0] + colour[1] + colour[2];
  negative = 0;
  for (int c = 0; c < 3; ++c) {
    if (colour[c] < Real(0)) negative |= 1u << c;
    drawn[c] = max_of(colour[c], Real(0));
  }
  return sum - sum == Real(0);
}

}  // namespace tessera
