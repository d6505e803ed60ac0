// Interval arithmetic on sorted times in seconds.
#include "ingest/clocks/frame_window.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr double kRounding = 1e-9;  // seconds; far below a tick, far above the error of a double

double half_distance(const std::vector<double>& seconds) {
  std::vector<double> distances;
  for (size_t i = 1; i < seconds.size(); ++i) distances.push_back(seconds[i] - seconds[i - 1]);
  if (distances.empty()) return 0;
  return 0.5 * lower_median(std::move(distances));
}

size_t nearest(const std::vector<double>& seconds, double instant) {
  const auto after = std::lower_bound(seconds.begin(), seconds.end(), instant);
  if (after == seconds.begin()) return 0;
  if (after == seconds.end()) return seconds.size() - 1;
  const auto index = size_t(after - seconds.begin());
  return instant - seconds[index - 1] <= seconds[index] - instant ? index - 1 : index;
}

std::vector<size_t> every_frame(const std::vector<double>& seconds, double start, double end) {
  const auto begin = std::lower_bound(seconds.begin(), seconds.end(), start - kRounding);
  const auto stop = std::lower_bound(begin, seconds.end(), end - kRounding);
  std::vector<size_t> kept;
  for (auto frame = begin; frame != stop; ++frame) kept.push_back(size_t(frame - seconds.begin()));
  return kept;
}

/// The nearest frames of start + k / fps for 0 <= k < count.
std::vector<size_t> at_rate(const std::vector<double>& seconds, double start, double fps,
                            int64_t count) {
  std::vector<size_t> kept;
  for (int64_t k = 0; k < count; ++k) {
    const double instant = start + double(k) / fps;
    const size_t frame = nearest(seconds, instant);
    if (std::abs(seconds[frame] - instant) > 0.5 / fps + kRounding) continue;
    if (kept.empty() || frame > kept.back()) kept.push_back(frame);
  }
  return kept;
}

}  // namespace

void check_start(const FrameWindow& window, const TimeInterval& clip, const std::string& where) {
  const double length = clip.last - clip.first;
  if (window.start > length)
    throw InputError(fmt::format("{}: --start {} s is after the end ({:.3f} s); pass less", where,
                                 window.start, length));
}

std::vector<size_t> choose_frames(const std::vector<double>& seconds, const FrameWindow& window,
                                  const TimeInterval& clip) {
  if (seconds.empty() || clip.empty()) return {};
  const double start = clip.first + window.start;
  const double length = window.duration.value_or(INFINITY);
  const int64_t limit = window.frames.value_or(INT64_MAX);
  if (window.fps) {
    check(*window.fps > 0, "a frame rate is positive");
    const double rate = *window.fps;
    const double asked = std::ceil((length - kRounding) * rate);  // k / fps < duration
    const double available = std::floor((clip.last - start + kRounding) * rate) + 1;  // <= last
    const double count = std::min({asked, available, double(limit)});
    return at_rate(seconds, start, rate, int64_t(count));
  }
  const double half = half_distance(seconds);
  const double clip_end = std::nextafter(clip.last + half + 2 * kRounding, INFINITY);
  std::vector<size_t> kept =
      every_frame(seconds, start - half, std::min(start + length - half, clip_end));
  if (int64_t(kept.size()) > limit) kept.resize(size_t(limit));
  return kept;
}

}  // namespace tessera
