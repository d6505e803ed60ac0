// The time in which a moving Gaussian is drawn, and the level and segment in which it is stored.
// Source: docs/reference/tessera4d.md, sections 1 and 5.
#pragma once
#include <compare>
#include <cstdint>
#include <optional>

#include "static3d/tessera4d/manifest.h"

namespace tessera {

/// Normalised timesteps within the clip, [0, 1], at which it is drawn; nothing where it never is.
/// `opacity`: σ(logit); `cutoff`: of the model.
std::optional<Interval> drawn_in_clip(double time_mean, double log_time_scale, double opacity,
                                      const Cutoff<double>& cutoff);

/// A place in the pyramid of segments; level 1 has the shortest.
struct TimeCell {
  int level = 1;
  int64_t segment = 0;
  auto operator<=>(const TimeCell&) const = default;
};

/// Length of the segments of a level, where those of level 1 are `shortest` long.
double segment_length(int level, double shortest);
/// The lowest level whose segments are at least as long as `drawn`, or as the clip; the segment
/// where it is first drawn.
TimeCell cell_of(const Interval& drawn, double shortest);

}  // namespace tessera
