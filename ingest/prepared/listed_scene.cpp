// Places the world and normalises the times.
#include "ingest/prepared/listed_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/clocks/timesteps.h"
#include "ingest/files/point_cloud.h"
#include "ingest/poses/far_origin.h"
#include "ingest/poses/world_normalisation.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Poses and points in a world that can be trained in, whichever frames are loaded. A prepared
/// scene's is.
void place_world(const std::filesystem::path& folder, TransformsCapture& capture, Scene& scene) {
  const bool is_prepared = capture.prepared_axis.has_value();
  std::vector<glm::dvec3> centres;
  for (const TransformsFrame& frame : capture.frames) centres.push_back(frame.camera.position());
  const glm::dvec3 origin = is_prepared ? glm::dvec3(0) : far_origin(centres);
  scene.points = find_points(folder, capture.points_file, scene.warnings, origin);
  scene.prepared_from_source = capture.prepared_from_source;
  if (is_prepared) return;
  std::vector<Camera> training;
  for (TransformsFrame& frame : capture.frames) {
    frame.camera = camera_in_world(less(origin), frame.camera);
    if (frame.split == Split::kTrain) training.push_back(frame.camera);
  }
  const Similarity change = usable_from_stated(training, scene.points);
  for (TransformsFrame& frame : capture.frames)
    frame.camera = camera_in_world(change, frame.camera);
  move_points(change, scene.points);
  scene.prepared_from_source = compose(change, less(origin));
}

void scale_readout(double factor, TransformsFrame& frame) {
  frame.camera.readout *= factor;
  if (frame.intrinsics.readout) *frame.intrinsics.readout *= factor;
}

/// States points on the axis of a part of the clip. Those that are seen at other times say nothing
/// of it and are left out, and a cloud that says what stands still, as a sweep makes it anew.
void cut_points(const TimeAxis& clip, const TimeAxis& part, PointCloud& points) {
  if (!points.still.empty()) points = {};  // of a sweep over few timesteps of the clip
  const std::vector<float> before = points.time;
  change_time_axis(points, clip, part);
  const auto is_elsewhere = [&](size_t i) {
    return !before.empty() && std::isfinite(before[i]) && !std::isfinite(points.time[i]);
  };
  PointCloud kept;
  for (size_t i = 0; i < points.position.size(); ++i) {
    if (is_elsewhere(i)) continue;
    kept.position.push_back(points.position[i]);
    kept.colour.push_back(points.colour[i]);
    if (!points.time.empty()) kept.time.push_back(points.time[i]);
    if (!points.velocity.empty()) kept.velocity.push_back(points.velocity[i]);
  }
  points = std::move(kept);
}

}  // namespace

void ListedScene::cut(const Window& window) {
  if (scene.is_static)
    throw InputError(
        fmt::format("{}: has one timestep, which makes no windows; train it without", scene.path));
  const TimestepRange range =
      range_of(window, 1 + *std::max_element(timestep.begin(), timestep.end()));
  ListedScene kept;
  double low = 1, high = 0;
  for (size_t i = 0; i < timestep.size(); ++i) {
    if (timestep[i] < range.first || timestep[i] > range.last) continue;
    kept.capture.frames.push_back(std::move(capture.frames[i]));
    kept.time.push_back(time[i]);
    kept.timestep.push_back(timestep[i] - range.first);
    low = std::min(low, time[i]);
    high = std::max(high, time[i]);
  }
  for (double& of_frame : kept.time) of_frame = (of_frame - low) / (high - low);
  const TimeAxis& axis = scene.time_axis;
  const TimeAxis part{axis.origin + low * axis.duration, (high - low) * axis.duration};
  for (TransformsFrame& frame : kept.capture.frames) scale_readout(1 / (high - low), frame);
  cut_points(axis, part, scene.points);
  scene.time_axis = part;
  capture.frames = std::move(kept.capture.frames);
  time = std::move(kept.time);
  timestep = std::move(kept.timestep);
}

ListedScene list_scene(const std::filesystem::path& folder, bool allow_static) {
  ListedScene listed;
  TransformsCapture& capture = listed.capture = read_transforms(folder);
  Scene& scene = listed.scene;
  scene.path = folder.string();
  scene.warnings = std::move(capture.warnings);
  scene.warnings.insert(scene.warnings.end(), capture.notes.begin(), capture.notes.end());
  place_world(folder, capture, scene);
  NormalisedTimes times = times_of(capture, allow_static);
  scene.time_axis = times.axis;
  scene.is_static = times.is_static;
  scene.static_of = capture.prepared_static_of;
  scene.measured_clocks = capture.measured_clocks;
  std::vector<FrameTime> frames;
  for (TransformsFrame& frame : capture.frames)  // states seconds
    scale_readout(scene.is_static ? 0 : 1 / scene.time_axis.duration, frame);
  for (size_t i = 0; i < times.time.size(); ++i)
    frames.push_back({capture.frames[i].camera_name, times.time[i], capture.frames[i].split});
  listed.time = std::move(times.time);
  listed.timestep = timestep_numbers(frames);
  return listed;
}

}  // namespace tessera
