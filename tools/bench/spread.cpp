// What: sorting and one pass for each.
// Not: any file.
#include "tools/bench/spread.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"

namespace tessera {

std::optional<Spread> spread_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return Spread{0.5 * (values[(n - 1) / 2] + values[n / 2]), values.front(), values.back(),
                int64_t(n)};
}

std::vector<size_t> pareto_front_of(const std::vector<TimedScore>& points) {
  std::vector<size_t> order(points.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return points[a].seconds != points[b].seconds ? points[a].seconds < points[b].seconds
                                                  : points[a].psnr > points[b].psnr;
  });
  std::vector<size_t> frontier;
  for (size_t i : order)
    if (frontier.empty() || points[i].psnr > points[frontier.back()].psnr) frontier.push_back(i);
  return frontier;
}

std::optional<size_t> knee_of(const std::vector<TimedScore>& points) {
  for (const TimedScore& point : points)
    check(point.seconds > 0, "knee_of: a logarithm of seconds > 0");
  const std::vector<size_t> frontier = pareto_front_of(points);
  if (frontier.size() < 3) return std::nullopt;
  const TimedScore &first = points[frontier.front()], &last = points[frontier.back()];
  const double time = std::log(last.seconds / first.seconds), gain = last.psnr - first.psnr;
  std::optional<size_t> knee;
  double farthest = 0;
  for (size_t i : frontier) {
    // the line is y = x; the distance from it is (y − x) / √2
    const double x = std::log(points[i].seconds / first.seconds) / time;
    const double y = (points[i].psnr - first.psnr) / gain;
    if (y - x > farthest) {
      farthest = y - x;
      knee = i;
    }
  }
  return knee;
}

}  // namespace tessera
