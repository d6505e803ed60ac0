// What: durations as typed, and the room that leaving takes.
// Not: signals (interrupt.h).
#include "tools/session/time_limit.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <utility>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

double seconds_of_unit(char unit) {
  switch (unit) {
    case 'h':
      return 3600;
    case 'm':
      return 60;
    case 's':
      return 1;
    default:
      return 0;
  }
}

}  // namespace

double parse_duration(const std::string& text) {
  const auto refuse = [&] {
    return InputError(fmt::format(
        "'{}' is no duration; pass seconds above 0 (7200) or hours, minutes and seconds (1h30m)",
        text));
  };
  double sum = 0;
  const char *cursor = text.data(), *const end = cursor + text.size();
  while (cursor != end) {
    double number = 0;
    const auto [after, error] = std::from_chars(cursor, end, number, std::chars_format::fixed);
    if (error != std::errc()) throw refuse();
    const bool bare = after == end && cursor == text.data();
    const double unit = bare ? 1 : after == end ? 0 : seconds_of_unit(*after);
    if (!(unit > 0) || !(number >= 0) || !std::isfinite(number)) throw refuse();
    sum += number * unit;
    cursor = bare ? after : after + 1;
  }
  if (!(sum > 0)) throw refuse();
  return sum;
}

Stopwatch running_stopwatch() {
  const auto begin = std::chrono::steady_clock::now();
  return [begin] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
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
