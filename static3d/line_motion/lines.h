// A clip as lines, which is what 4D splat files of other programs hold: each Gaussian moves along a
// line, mean + v·(t − μ_t), and fades by exp(−½ ((t − μ_t) / σ_t)²). In memory it is a
// GaussianModel without nodes whose dynamic set is of the form kVelocity, on the time axis of the
// clip.
#pragma once
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// σ_t of what stands still, normalised time, where a file holds floats.
inline constexpr double kLongLife = 1000;

/// The highest SH degree that is drawn of such a model.
int drawn_degree(const GaussianModel& model);
/// All its sound Gaussians as lines with unit quaternions and SH of `degree`, where they have fewer
/// with zeros. The static ones come first: without velocity, at the middle of the clip, with
/// `still_extent` for σ_t, normalised time.
GaussianSet lines_of(const GaussianModel& model, int degree, double still_extent);

/// The rows of a set, from row `first` of another on; groups and SH that only one has are left.
void copy_rows(const GaussianSet& from, int64_t first, GaussianSet& to);

/// The way back: lines that do not move by a thousandth of their smallest scale in the clip, and
/// keep 99.5 % of their opacity through it, become static Gaussians.
GaussianModel model_of_lines(const GaussianSet& lines, const TimeAxis& axis);

}  // namespace tessera
