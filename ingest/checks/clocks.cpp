// What: standard errors of clocks by the distance of their frames.
// Not: whether the offsets are right.
#include "ingest/checks/clocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "ingest/held_out_cameras.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

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

}  // namespace

namespace {

constexpr double kVague = 0.25;  // frames, as where the preparation warns

struct VagueClock {
  const RecordedClock* clock;
  double frames;  // its standard error
};

std::string done_with(const RecordedClock& clock) {
  return clock.offset == 0 ? std::string("it was left at 0")
                           : fmt::format("it was set by {:+.4f} s", clock.offset);
}

/// One finding, however many cameras: what can be done about it is the same for all.
Finding vague_finding(const std::vector<VagueClock>& vague) {
  const char* const advice = "state the clocks with --offsets FILE, or film a clap that all see";
  const RecordedClock& first = *vague.front().clock;
  if (vague.size() == 1)
    return {Severity::kWarning, "sync", first.camera,
            fmt::format("its clock is only known to {:.4f} s, {:.2f} of a frame; {}",
                        first.uncertainty, vague.front().frames, done_with(first)),
            advice};
  std::vector<std::string> names;
  double seconds = 0, frames = 0;
  bool moved = false;
  for (const VagueClock& one : vague) {
    names.push_back(one.clock->camera);
    seconds = std::max(seconds, one.clock->uncertainty);
    frames = std::max(frames, one.frames);
    moved = moved || one.clock->offset != 0;
  }
  return {Severity::kWarning, "sync", "",
          fmt::format("the clocks of {} are only known to {:.4f} s, {:.2f} of a frame, or better; "
                      "{}",
                      listed_names(names), seconds, frames,
                      moved ? "they were set by what was measured" : "they were left at 0"),
          advice};
}

}  // namespace

Findings check_clocks(const Scene& scene, const std::vector<RecordedClock>& clocks) {
  const auto frame_seconds = frame_seconds_of(scene);
  Findings findings;
  std::vector<VagueClock> vague;
  size_t unnamed = 0;
  for (const RecordedClock& clock : clocks) {
    const auto step = frame_seconds.find(clock.camera);
    const bool unknown = clock.source == "none" && clock.uncertainty > 0;
    if (!unknown && step != frame_seconds.end() && clock.uncertainty > kVague * step->second)
      vague.push_back({&clock, clock.uncertainty / step->second});
    if (!unknown) continue;
    if (findings.size() == kMostNamed) {
      ++unnamed;
      continue;
    }
    findings.push_back(
        {Severity::kWarning, "sync", clock.camera,
         fmt::format("its clock could not be measured against the others'; {}", done_with(clock)),
         "state the clocks with --offsets FILE, or film a clap that all see"});
  }
  if (unnamed > 0)
    findings.push_back({Severity::kWarning, "sync", "",
                        fmt::format("{} more clocks are not known well", unnamed),
                        "state the clocks with --offsets FILE"});
  if (!vague.empty()) findings.push_back(vague_finding(vague));
  return findings;
}

}  // namespace tessera
