// Points that lie beside the capture come first; poses that were stated give some otherwise.
#include <algorithm>
#include <cmath>

#include "ingest/colmap/pose_estimation.h"
#include "ingest/colmap/rig_background.h"
#include "ingest/files/point_cloud.h"
#include "ingest/steps/clip_times.h"
#include "ingest/steps/steps.h"

namespace tessera {
namespace {

/// A few timesteps spread over the kept frames of the first clip, with each clip's nearest frame.
std::vector<RigInstant> spread_instants(const Capture& capture) {
  constexpr size_t kInstants = 4;
  const std::vector<std::vector<double>> times = clip_times(capture);
  const std::vector<int64_t>& ticks = capture.clips.front().timeline.ticks;
  std::vector<size_t> kept;  // frames of the first clip
  for (const CaptureFrame& frame : capture.frames)
    if (frame.frame.camera_name == capture.clips.front().name)
      kept.push_back(
          size_t(std::lower_bound(ticks.begin(), ticks.end(), *frame.ticks) - ticks.begin()));
  std::vector<RigInstant> instants;
  for (const size_t k : spread_frames(kept.size(), kInstants)) {
    const double timestep = times[0][kept[k]];
    RigInstant instant{(timestep - capture.time_axis.origin) / capture.time_axis.duration, {}};
    for (const std::vector<double>& of_clip : times) {
      const auto nearest = std::min_element(
          of_clip.begin(), of_clip.end(),
          [&](double a, double b) { return std::abs(a - timestep) < std::abs(b - timestep); });
      instant.frame.emplace_back(size_t(nearest - of_clip.begin()));
    }
    instants.push_back(std::move(instant));
  }
  return instants;
}

}  // namespace

Capture read_points(Capture capture, const StepContext& context) {
  if (!capture.points_file) return capture;
  const IngestOptions& options = context.options;
  capture.points =
      find_points(capture.folder, *capture.points_file, capture.warnings, capture.origin);
  if (capture.points_axis)
    change_time_axis(capture.points, *capture.points_axis, capture.time_axis);
  if (!capture.clips.empty() && options.cloud == CloudDensity::kSparse &&
      capture.points.position.empty())
    capture.points = triangulate_instants(capture.clips, capture.held_out, spread_instants(capture),
                                          options.work / "points", options.poses, context.progress);
  return capture;
}

}  // namespace tessera
