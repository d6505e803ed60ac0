// Computes evenly spaced timesteps and timesteps at a rate, and parses --range.
#include "tools/camera_paths/export_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr double kDefaultFps = 24;     // frames per unit of the capture's clock, if it is not known
constexpr int64_t kMostDefault = 300;  // frames by default
constexpr int64_t kMostFrames = 100000;  // frames on request
constexpr double kRounding = 1e-6;  // of a frame: a last timestep that rounding puts past the end

/// `count` timesteps from the first to the last.
std::vector<double> spread(int64_t count, const TimeRange& range) {
  std::vector<double> times(static_cast<size_t>(count), range.begin);
  for (size_t i = 1; i < times.size(); ++i)
    times[i] = range.begin + (range.end - range.begin) * (double(i) / double(count - 1));
  return times;
}

/// Timesteps 1/fps apart from the first on.
std::vector<double> at_rate(double fps, double duration, const TimeRange& range) {
  const double seconds = duration * (range.end - range.begin);
  const double last = std::floor(fps * seconds + kRounding);
  if (!(fps > 0) || !(last < double(kMostFrames)))
    throw InputError(
        fmt::format("export: --fps {} over {} seconds makes {} frames, expected 1 to "
                    "{}; pass --frames",
                    fps, seconds, last + 1, kMostFrames));
  std::vector<double> times;
  for (int64_t i = 0; i <= int64_t(last); ++i)
    times.push_back(std::min(range.end, range.begin + double(i) / (fps * duration)));
  return times;
}

/// Of at least two times.
double rate_of(const std::set<double>& timesteps) {
  std::vector<double> steps;
  for (auto next = std::next(timesteps.begin()); next != timesteps.end(); ++next)
    steps.push_back(*next - *std::prev(next));
  const double usual = lower_median(steps);
  double frames = 0;  // the clock of a container may be coarse: the sum has no error of the median
  for (const double step : steps) frames += std::max(1.0, std::round(step / usual));
  return frames / (*timesteps.rbegin() - *timesteps.begin());
}

InputError range_error(const std::string& text, const std::string& reason) {
  return InputError(
      fmt::format("export: --range {}: {}; expected A:B, each 0 (first) to 1 (last) or seconds as "
                  "in 2s:3.5s",
                  text, reason));
}

/// One end of a range in normalised time.
double range_end(const std::string& word, double when_absent, const std::string& text,
                 const TimeAxis& axis) {
  if (word.empty()) return when_absent;
  const bool seconds = word.back() == 's';
  const std::string digits = seconds ? word.substr(0, word.size() - 1) : word;
  const char* const end = digits.data() + digits.size();
  double value = 0;
  const auto [stopped, error] = std::from_chars(digits.data(), end, value);  // in no locale
  if (error != std::errc() || stopped != end || !std::isfinite(value))
    throw range_error(text, fmt::format("'{}' is no timestep", word));
  return seconds ? value / axis.duration : value;
}

}  // namespace

TimeRange parse_time_range(const std::string& text, const TimeAxis& axis) {
  const size_t colon = text.find(':');
  if (colon == std::string::npos) throw range_error(text, "has no colon");
  TimeRange range{range_end(text.substr(0, colon), 0, text, axis),
                  range_end(text.substr(colon + 1), 1, text, axis)};
  const double rounding = 1e-9;
  if (range.begin < 0 || range.end > 1 + rounding)
    throw range_error(text, fmt::format("the clip lasts {} s", axis.duration));
  if (!(range.begin < range.end)) throw range_error(text, "its end is not after its beginning");
  range.end = std::min(range.end, 1.0);
  return range;
}

double capture_rate(const CameraTimesteps& cameras) {
  std::vector<double> rates;
  std::set<double> single;
  for (const auto& [name, timesteps] : cameras) {
    if (timesteps.size() > 1)
      rates.push_back(rate_of(timesteps));
    else
      single.insert(timesteps.begin(), timesteps.end());
  }
  if (single.size() > 1 && rates.empty()) rates.push_back(rate_of(single));
  return rates.empty() ? 0 : lower_median(std::move(rates));
}

std::vector<double> capture_times(const CameraTimesteps& cameras, int64_t most) {
  std::set<double> all;
  for (const auto& [name, timesteps] : cameras) all.insert(timesteps.begin(), timesteps.end());
  if (all.empty()) return {};
  const TimeRange whole{*all.begin(), *all.rbegin()};
  const double count = std::round(capture_rate(cameras) * (whole.end - whole.begin)) + 1;
  return spread(int64_t(std::min(count, double(most))), whole);
}

std::vector<double> export_times(const ExportTimes& request, const TimeAxis& axis, bool moves) {
  if (request.time) {
    if (!(*request.time >= 0 && *request.time <= 1))
      throw InputError(
          fmt::format("export: --time is {}, expected 0 (first) to 1 (last)", *request.time));
    return {*request.time};
  }
  const TimeRange range =
      request.range.empty() ? TimeRange{} : parse_time_range(request.range, axis);
  if (request.frames) {
    if (*request.frames < 1 || *request.frames > kMostFrames)
      throw InputError(
          fmt::format("export: --frames is {}, expected 1 to {}", *request.frames, kMostFrames));
    return spread(*request.frames, range);
  }
  if (request.fps) return at_rate(*request.fps, axis.duration, range);
  if (!moves) return {range.begin};
  const double seconds = axis.duration * (range.end - range.begin);
  const double count = std::round(request.capture_fps.value_or(kDefaultFps) * seconds) + 1;
  return spread(int64_t(std::clamp(count, 2.0, double(kMostDefault))), range);
}

}  // namespace tessera
