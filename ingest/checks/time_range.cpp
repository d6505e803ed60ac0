// Compares the times of each camera to its median frame distance and to the other cameras. Times
// are normalised; the time axis converts them to seconds.
#include "ingest/checks/time_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "ingest/checks/stations.h"
#include "ingest/test_views.h"
#include "kernels/base/counted.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

/// Frames that fail in a camera whose usual distance between frames is the median one.
int64_t missing_timesteps(const std::vector<double>& times) {
  if (times.size() < 3) return 0;
  std::vector<double> steps;
  for (size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  const double usual = median(steps);
  int64_t missing = 0;
  if (usual > 0)
    for (const double step : steps) missing += std::max<int64_t>(0, std::llround(step / usual) - 1);
  return missing;
}

/// The mean distance of a camera's frames, of the clip.
double distance_of(const CameraTimes& camera) {
  return (camera.last - camera.first) / double(std::max<int64_t>(1, camera.frames - 1));
}

void judge_cameras(SceneTimes& range) {
  std::vector<double> firsts, lasts, distances;
  for (const CameraTimes& camera : range.cameras) {
    firsts.push_back(camera.first);
    lasts.push_back(camera.last);
    distances.push_back(distance_of(camera));
  }
  std::sort(firsts.begin(), firsts.end());
  std::sort(lasts.begin(), lasts.end());
  const double first = firsts[firsts.size() / 2], last = lasts[lasts.size() / 2];
  const double usual = lower_median(std::move(distances));
  size_t named = 0;
  for (const CameraTimes& camera : range.cameras) {
    constexpr double kApart = 0.02;  // of the clip
    constexpr double kHalf = 0.55;   // of a distance: frames of two rates are half of one apart
    const double apart = std::max(kApart, kHalf * std::max(usual, distance_of(camera)));
    if (std::abs(camera.first - first) > apart || std::abs(camera.last - last) > apart) {
      if (++named <= kMostNamed)
        range.findings.push_back(
            {Severity::kWarning, "time", camera.camera,
             fmt::format("covers {:.3f} to {:.3f} of the clip, most cameras {:.3f} to {:.3f}",
                         camera.first, camera.last, first, last),
             "the other cameras alone show the rest; where it did film it, check the clock "
             "offsets"});
    }
    if (camera.missing > 0 && ++named <= kMostNamed)
      range.findings.push_back(
          {Severity::kWarning, "time", camera.camera,
           fmt::format("{} timesteps are missing between its {} frames", camera.missing,
                       camera.frames),
           "frames were dropped: check the video; training continues without them"});
  }
}

/// The median distance of each camera's frames in seconds; none for a camera of one timestep.
std::map<std::string, double> frame_seconds_of(const Scene& scene) {
  std::map<std::string, std::set<double>> times;
  for (const Frame& frame : scene.frames) times[frame.camera_name].insert(frame.time);
  std::map<std::string, double> seconds;
  for (const auto& [camera, timesteps] : times) {
    std::vector<double> steps;
    for (auto next = timesteps.begin(), previous = next++; next != timesteps.end();
         previous = next++)
      steps.push_back(*next - *previous);
    if (steps.empty()) continue;
    seconds[camera] = lower_median(std::move(steps)) * scene.time_axis.duration;
  }
  return seconds;
}

constexpr double kVague = 0.25;  // frames, as where the preparation warns

}  // namespace

SceneTimes check_times(const Scene& scene, bool in_seconds) {
  SceneTimes range;
  std::set<int64_t> timesteps;
  std::map<std::string, std::set<double>> of_camera;
  for (const Frame& frame : scene.frames) {
    timesteps.insert(frame.timestep);
    of_camera[frame.camera_name].insert(frame.time);
  }
  range.timesteps = int64_t(timesteps.size());
  range.duration = scene.time_axis.duration;
  range.is_static = timesteps.size() <= 1;
  for (const auto& [name, times] : of_camera) {
    const std::vector<double> list(times.begin(), times.end());
    range.cameras.push_back(
        {name, int64_t(list.size()), list.front(), list.back(), missing_timesteps(list)});
  }
  if (range.is_static && !scene.is_static)
    range.findings.push_back({Severity::kWarning, "time", "",
                              "all frames have one time though several were stated",
                              "check the times, or train with --motion none"});
  // A camera of several poses moves, and the times of its splits may differ.
  const bool rig = stations_of(scene).size() == of_camera.size();
  if (!range.is_static && rig) judge_cameras(range);
  range.findings.push_back(
      {Severity::kInfo, "time", "",
       fmt::format("{} of {}, {} {:.4g}{}", counted(range.timesteps, "timestep"),
                   counted(int64_t(range.cameras.size()), "camera"),
                   in_seconds ? "over" : "times as stated, from first to last", range.duration,
                   in_seconds ? " s" : ""),
       ""});
  return range;
}

double dynamic_share(const Scene& scene) {
  constexpr int kMoved = 26;  // levels of 255
  double sum = 0;
  int64_t stations = 0;
  for (const Station& station : training_stations(scene)) {
    if (station.frames.size() < 2) continue;
    std::vector<uint8_t> low = scene.frames[size_t(station.frames.front())].image.data, high = low;
    for (const int index : station.frames) {
      const std::vector<uint8_t>& data = scene.frames[size_t(index)].image.data;
      for (size_t k = 0; k < data.size(); ++k) {
        low[k] = std::min(low[k], data[k]);
        high[k] = std::max(high[k], data[k]);
      }
    }
    int64_t moved = 0;
    for (size_t p = 0; p + 2 < low.size(); p += 3) {
      int most = 0;
      for (size_t k = p; k < p + 3; ++k) most = std::max(most, high[k] - low[k]);
      moved += most > kMoved;
    }
    sum += 3.0 * double(moved) / double(low.size());
    ++stations;
  }
  return stations == 0 ? -1 : sum / double(stations);
}

Findings check_clocks(const Scene& scene, const std::vector<RecordedClock>& clocks) {
  const auto frame_seconds = frame_seconds_of(scene);
  std::vector<std::string> unknown, vague;
  double farthest = 0;
  for (const RecordedClock& clock : clocks) {
    farthest = std::max(farthest, std::abs(clock.offset));
    const auto step = frame_seconds.find(clock.camera);
    if (clock.source == "none" && clock.uncertainty > 0)
      unknown.push_back(clock.camera);
    else if (step != frame_seconds.end() && clock.uncertainty > kVague * step->second)
      vague.push_back(
          fmt::format("{} (± {:.2f} frames)", clock.camera, clock.uncertainty / step->second));
  }
  const bool off = farthest > 0;  // else nothing speaks against the clocks
  Findings findings;
  const auto name = [&](const std::vector<std::string>& cameras, const char* what) {
    if (cameras.empty()) return;
    findings.push_back(
        {off ? Severity::kWarning : Severity::kInfo, "sync", "",
         fmt::format("the clocks of {} {}; {}", listed_names(cameras), what,
                     off ? fmt::format("there are offsets of up to {:.3f} s", farthest)
                         : "they are taken as they are"),
         off ? "state the clocks with --offsets FILE, or film a clap that all see" : ""});
  };
  name(unknown, "could not be measured");
  name(vague, "are known roughly");
  return findings;
}

}  // namespace tessera
