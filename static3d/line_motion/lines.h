// A clip as lines, which is what 4D splat files of other programs hold: each Gaussian moves along a
// line, mean + v·(t − μ_t), and fades by exp(−½ ((t − μ_t) / σ_t)²). In memory it is a
// GaussianModel without nodes whose dynamic set is of the form kVelocity, on the time axis of the
// clip.
#pragma once
#include <vector>

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

/// All zeros but for the rows of these sets, one set after the other; groups and SH that only one
/// of both has are left.
GaussianSet joined_sets(const std::vector<const GaussianSet*>& sets, SetForm form,
                        int coefficients);
/// Lines alone, with the SH of the highest degree.
GaussianSet joined_lines(const std::vector<GaussianSet>& sets);

/// The sound Gaussians, with unit quaternions.
GaussianSet sound_set(const GaussianSet& set);

/// The way back: lines that do not move by a thousandth of their smallest scale in the clip, and
/// keep 99.5 % of their opacity through it, become static Gaussians.
GaussianModel model_of_lines(const GaussianSet& lines, const TimeAxis& axis);

}  // namespace tessera
