// Parses durations and computes the time that is reserved for saving before the limit.
#include "tools/session/clock/time_limit.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/base/seconds_since.h"
#include "recon4d/options/option_value.h"

namespace tessera {

double parse_duration(const std::string& text) {
  const std::optional<double> seconds = parse_quantity(text, Unit::kSeconds);
  if (!seconds || !(*seconds > 0))
    throw InputError(
        fmt::format("'{}' is no duration; pass {}", text, quantity_example(Unit::kSeconds)));
  return *seconds;
}

Stopwatch running_stopwatch() {
  const auto begin = std::chrono::steady_clock::now();
  return [begin] { return seconds_since(begin); };
}

TimeLimit::TimeLimit(double seconds, Stopwatch now) : seconds_(seconds), now_(std::move(now)) {}

void TimeLimit::saved(double seconds, int64_t gaussians) {
  const double count = double(std::max<int64_t>(gaussians, 1));
  if (seconds * saved_gaussians_ < save_seconds_ * count) return;
  save_seconds_ = seconds;
  saved_gaussians_ = count;
}

bool TimeLimit::due_after_step(int64_t gaussians) {
  const double now = now_();
  longest_step_ = std::max(longest_step_, now - stepped_);
  stepped_ = now;
  return due(gaussians);
}

bool TimeLimit::due(int64_t gaussians) const {
  if (!on()) return false;
  const double growth = std::max(1.0, double(gaussians) / saved_gaussians_);
  const double room = longest_work_ + longest_step_ + 2 * save_seconds_ * growth + margin();
  return now_() + room >= seconds_;
}

bool TimeLimit::over() const {
  return on() && now_() + margin() >= seconds_;
}

}  // namespace tessera
