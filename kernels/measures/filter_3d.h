// The 3D filter of one stored Gaussian: its size φ from the views that sample it, and the edits of
// its parameters. Source: [Mip-Splatting], [Faster-GS]; method C.1.
#pragma once
#include "kernels/load_gaussian.h"

namespace tessera {

/// φ of the 3D filter of Gaussian n from what each view that samples it sees; −1 where none does.
/// In 4D a view sees the mean at its own time, if the Gaussian is drawn then at all.
template <SetForm form, class Real>
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

/// The edit of Gaussian n of a set with its φ. `limit`: an opacity.
template <class Real>
TESSERA_HD inline void edit_by_filter(FilterEdit edit, const GaussianSpans<Real>& set, int64_t n,
                                      Real limit) {
  const Real size = set.filter_size[n];
  Real* const s = set.at(kLogScale, n);
  Real* const logit = set.at(kOpacityLogit, n);
  if (edit == FilterEdit::kRaiseScales) {
    const Real least = log(size);  // −∞ without a filter
    for (int k = 0; k < 3; ++k) s[k] = max_of(least, s[k]);
    return;
  }
  const Smoothed<Real> smoothed = smooth(Vec3<Real>(s[0], s[1], s[2]), size);
  if (edit == FilterEdit::kBake) {
    *logit = logit_of_compensated(*logit, smoothed.compensation);
    for (int k = 0; k < 3; ++k) s[k] = smoothed.log_scale[k];
    return;
  }
  if (smoothed.compensation > limit)  // else o' ≤ c ≤ limit already
    *logit = min_of(*logit, log(limit / (smoothed.compensation - limit)));
}

}  // namespace tessera
