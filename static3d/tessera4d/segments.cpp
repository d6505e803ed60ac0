// The interval in which a Gaussian is drawn, and the segments of each level.
#include "static3d/tessera4d/segments.h"

#include <algorithm>
#include <cmath>

#include "kernels/math/spacetime.h"

namespace tessera {
namespace {

constexpr double kGrowth = 4;       // of the length from level to level
constexpr double kRounding = 1e-5;  // of a reach: readers work in float

}  // namespace

std::optional<Interval> drawn_in_clip(double time_mean, double log_time_scale, double opacity,
                                      const Cutoff<double>& cutoff) {
  if (!cutoff.keeps(opacity)) return {};
  double fall = -std::log(kMinMarginal<double>);  // ½Δ²/σ_t² at which it ends
  if (cutoff.least_alpha > 0) fall = std::min(fall, std::log(opacity / cutoff.least_alpha));
  const double reach = std::exp(log_time_scale) * std::sqrt(2 * fall) * (1 + kRounding);
  const Interval drawn{std::max(time_mean - reach, 0.0), std::min(time_mean + reach, 1.0)};
  if (!(drawn.low <= drawn.high)) return {};
  return drawn;
}

double segment_length(int level, double shortest) {
  return shortest * std::pow(kGrowth, level - 1);
}

TimeCell cell_of(const Interval& drawn, double shortest) {
  TimeCell cell;
  const double most = std::min(drawn.high - drawn.low, 1.0);
  while (segment_length(cell.level, shortest) < most) ++cell.level;
  const double length = segment_length(cell.level, shortest);
  if (length < 1) cell.segment = int64_t(drawn.low / length);
  return cell;
}

}  // namespace tessera
