// What: numbers of a benchmark: median and spread over seeds, the frontier of time and quality, its
//       knee.
// Not: what was measured (bench/report.h) or drawn (bench/scene_chart.h).
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

namespace tessera {

/// Of the seeds of a run. Of an even number the median is the mean of the middle two.
struct Spread {
  double median = 0, least = 0, most = 0;
  int64_t count = 0;
};

/// Values that are not finite do not count. Nothing where none is left.
std::optional<Spread> spread_of(std::vector<double> values);

/// A model that took `seconds` (> 0) to train and scores `psnr` dB.
struct TimedScore {
  double seconds = 0, psnr = 0;
};

/// Indices of the points that no other is at least as fast and at least as good as (of equal ones
/// the first), from the fastest to the best.
std::vector<size_t> pareto_front_of(const std::vector<TimedScore>& points);

/// The point of the frontier where more time begins to buy little: the one farthest above the
/// straight line from its fastest to its best point, with log(seconds) and PSNR each scaled to
/// [0, 1] between these two. Nothing where the frontier has fewer than three points or none lies
/// above the line.
std::optional<size_t> knee_of(const std::vector<TimedScore>& points);

}  // namespace tessera
