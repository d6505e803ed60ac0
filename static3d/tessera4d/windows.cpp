// Which window is drawn at a time, its own time, and the conditions that windows fulfil.
#include "static3d/tessera4d/windows.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera {

nlohmann::json list_of(const Interval& interval) {
  return {interval.low, interval.high};
}

nlohmann::json to_json(const FileWindow& window) {
  nlohmann::json object = {{"time", list_of(window.time)}, {"drawn", list_of(window.drawn)}};
  if (window.light != kSameLight) object["light"] = window.light;
  return object;
}

double window_time(const FileWindow& window, double t) {
  return (t - window.time.low) / (window.time.high - window.time.low);
}

double clip_time(const FileWindow& window, double tau) {
  return window.time.low + tau * (window.time.high - window.time.low);
}

TimeAxis window_axis(const FileWindow& window, const TimeAxis& clip) {
  return {clip.origin + window.time.low * clip.duration,
          (window.time.high - window.time.low) * clip.duration, clip.is_stated};
}

int window_at(const std::vector<FileWindow>& windows, double t) {
  const auto later =
      std::upper_bound(windows.begin(), windows.end(), t,
                       [](double time, const FileWindow& w) { return time < w.drawn.low; });
  return std::max(0, int(later - windows.begin()) - 1);
}

std::string wrong_windows(const std::vector<FileWindow>& windows) {
  if (windows.empty()) return "has no windows";
  double end = 0;
  for (size_t i = 0; i < windows.size(); ++i) {
    const auto& [time, drawn, light] = windows[i];
    if (!(drawn.low < drawn.high))
      return fmt::format("has an empty window {}, drawn from {} to {}", i, drawn.low, drawn.high);
    if (!(time.low <= drawn.low && drawn.high <= time.high))
      return fmt::format("has window {} drawn from {} to {}, outside of its time from {} to {}", i,
                         drawn.low, drawn.high, time.low, time.high);
    if (std::any_of(light.begin(), light.end(), [](double f) { return !(f > 0 && f < 100); }))
      return fmt::format("has window {} in a light that is not between 0 and 100", i);
    if (drawn.low != end)
      return fmt::format("has windows with {}: window {} begins at {}, expected {}",
                         drawn.low > end ? "a gap" : "an overlap", i, drawn.low, end);
    end = drawn.high;
  }
  if (end != 1) return fmt::format("has windows that end at {}, expected 1", end);
  return "";
}

}  // namespace tessera
