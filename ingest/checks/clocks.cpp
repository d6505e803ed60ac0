// What: standard errors of clocks by the distance of their frames.
// Not: whether the offsets are right.
#include "ingest/checks/clocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

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

Findings check_clocks(const Scene& scene, const std::vector<RecordedClock>& clocks) {
  constexpr double kVague = 0.25;  // frames, as where the preparation warns
  const auto frame_seconds = frame_seconds_of(scene);
  Findings findings;
  size_t unnamed = 0;
  for (const RecordedClock& clock : clocks) {
    const auto step = frame_seconds.find(clock.camera);
    const bool unknown = clock.source == "none" && clock.uncertainty > 0;
    const bool vague =
        step != frame_seconds.end() && clock.uncertainty > kVague * step->second && !unknown;
    if (!unknown && !vague) continue;
    if (findings.size() == kMostNamed) {
      ++unnamed;
      continue;
    }
    const std::string done = clock.offset == 0
                                 ? std::string("it was left at 0")
                                 : fmt::format("it was set by {:+.4f} s", clock.offset);
    findings.push_back(
        {Severity::kWarning, "sync", clock.camera,
         unknown ? fmt::format("its clock could not be measured against the others'; {}", done)
                 : fmt::format("its clock is only known to {:.4f} s, {:.2f} of a frame; {}",
                               clock.uncertainty, clock.uncertainty / step->second, done),
         "state the clocks with --offsets FILE, or film a clap that all cameras see"});
  }
  if (unnamed > 0)
    findings.push_back({Severity::kWarning, "sync", "",
                        fmt::format("{} more clocks are not known well", unnamed),
                        "state the clocks with --offsets FILE"});
  return findings;
}

}  // namespace tessera
