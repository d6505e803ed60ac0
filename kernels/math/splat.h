// One Gaussian in one view to one splat: slice, cull, project, colour and bounds, in that order.
// The forward and backward passes of every backend call these functions. Source: method A.5, A.6,
// C.1–C.3, D.1; 2D filter: [Mip-Splatting].
#pragma once
#include "kernels/math/bounds.h"
#include "kernels/math/filter_3d.h"
#include "kernels/math/spacetime.h"
#include "kernels/math/spherindrical.h"
#include "kernels/math/symmetric.h"

namespace tessera {

/// κ with the filter: the variance of a pixel, pixels²  [Mip-Splatting].
template <class Real>
inline constexpr Real kFilter2d = Real(0.1);

/// comp = √max(0, det(Σ2 − κI)/det Σ2), Σ2 with its dilation. The quotient is det(I − κ·conic).
template <class Real>
TESSERA_HD inline Real compensation(const Sym2<Real>& conic, Real dilation) {
  const Real x = Real(1) - dilation * conic.xx, y = Real(1) - dilation * conic.yy;
  const Real xy = dilation * conic.xy;
  return sqrt(max_of(Real(0), x * y - xy * xy));
}

template <class Real>
struct SplatRules {
  Real near_plane, far_plane;  // world units
  Real dilation;               // κ, pixels²
  Real time_filter;            // f, normalised time²: added to σ_t² in the marginal
  bool compensated;            // 2D filter: opacities are multiplied by comp
  Cutoff<Real> cutoff;
  BoundsOptions bounds;
};

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
struct ViewSplat {
  Slice<Real> slice;
  Projection<Real> projection;
  Real opacity;  // effective: o·p, with the 2D filter o·p·comp
  Real power;    // of the cut-off ellipse
  TileRect rect;
};

/// Direction from the camera to the Gaussian, and its length.
/// Deviation: both reference codes take the unconditional mean μ [method 0.19]; here it is the mean
/// at the time of the view: a frame exported as a static 3DGS file then renders equal to the 4D
/// model. The option sliced_direction restores theirs.
template <class Real>
TESSERA_HD inline Vec3<Real> view_direction(const ViewArgs<Real>& view, const Vec3<Real>& mean,
                                            Real& distance) {
  const Vec3<Real> offset = mean - view.position;
  distance = sqrt(dot(offset, offset));
  return offset * (Real(1) / distance);
}

/// Of an image row, pixels from the top: by how much later it is exposed than the middle one, as a
/// share of the readout.
template <class Real>
TESSERA_HD inline Real row_share(const ViewArgs<Real>& view, Real y) {
  const Real height = Real(view.height);
  return min_of(max_of(y, Real(0)), height) / height - Real(0.5);
}

/// The slice of g that a view shows: at the time of the view, with a rolling shutter at that of the
/// row in which this one lies. Gradients take the row for a constant: it changes them by what
/// the Gaussian moves during the readout, as a share of the image.
template <class Real>
TESSERA_HD inline Slice<Real> slice_in_view(const ViewArgs<Real>& view,
                                            const GaussianState<Real>& g, Real time_filter) {
  const Slice<Real> slice = slice_at(g.mean, g.spacetime, view.time, time_filter);
  if (view.readout == Real(0)) return slice;
  const Vec3<Real> in_cam = to_camera(view, slice.mean);
  if (!(in_cam[2] > Real(0))) return slice;
  const Real y = view.fl_y * in_cam[1] / in_cam[2] + view.cy;
  return slice_at(g.mean, g.spacetime, view.time + view.readout * row_share(view, y), time_filter);
}

/// row_share of the row at which slice_in_view took g; `y`: where it was drawn.
template <class Real>
TESSERA_HD inline Real shown_row_share(const ViewArgs<Real>& view, const GaussianState<Real>& g,
                                       const Slice<Real>& slice, Real y) {
  if (view.readout == Real(0)) return row_share(view, y);
  return (slice.delta - (view.time - g.spacetime.mean_time)) / view.readout;
}

/// Time of a view's colours, from the mean in time: they change too slowly to differ by row.
template <class Real>
TESSERA_HD inline Real colour_delta(const ViewArgs<Real>& view, const GaussianState<Real>& g) {
  return view.time - g.spacetime.mean_time;
}

/// False when the Gaussian is not drawn in this view.
template <class Real>
TESSERA_HD inline bool splat_in_view(const ViewArgs<Real>& view, const GaussianState<Real>& g,
                                     const SplatRules<Real>& rules, ViewSplat<Real>& out) {
  out.slice = slice_in_view(view, g, rules.time_filter);
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

/// The SH coefficients of g at a time: those that are stored, or, where levels of time are added
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
