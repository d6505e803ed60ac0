// What: views → places.
// Not: reading scenes (camera_views.h).
#include "tools/camera_paths/rig_cameras.h"

#include <algorithm>

#include "kernels/base/errors.h"
#include "tools/camera_paths/export_times.h"
#include "tools/session/run_folder.h"

namespace tessera {
namespace {

constexpr size_t kMostCameras = 32;

/// "cam00" of "cam00/00012": what a camera's frames have in common.
std::string station_name(const std::string& frame) {
  const size_t slash = frame.rfind('/');
  return slash == std::string::npos ? frame : frame.substr(0, slash);
}

bool taken(const std::vector<PlayerCamera>& cameras, const std::string& name) {
  return std::any_of(cameras.begin(), cameras.end(), [&](const auto& c) { return c.name == name; });
}

std::vector<PlayerCamera> places_of(const std::vector<NamedView>& views) {
  std::vector<PlayerCamera> all;
  for (const NamedView& named : views) {
    const Camera& camera = named.view.camera;
    if (std::any_of(all.begin(), all.end(), [&](const auto& c) { return c.camera == camera; }))
      continue;
    const std::string station = station_name(named.name);
    all.push_back({taken(all, station) ? named.name : station, camera});
  }
  if (all.size() <= kMostCameras) return all;
  std::vector<PlayerCamera> some;  // a camera that moved: evenly along its way
  for (size_t i = 0; i < kMostCameras; ++i) some.push_back(all[i * all.size() / kMostCameras]);
  return some;
}

}  // namespace

Rig rig_of_views(const std::vector<NamedView>& views, const TimeAxis& axis) {
  Rig rig;
  rig.cameras = places_of(views);
  CameraTimesteps timesteps;
  for (const NamedView& named : views) timesteps[station_name(named.name)].insert(named.view.time);
  rig.fps = capture_rate(timesteps) / axis.duration;
  return rig;
}

Rig rig_of(const std::string& cameras, const std::string& model_path, const GaussianModel& model) {
  CameraChoice choice;
  choice.cameras = cameras.empty() ? scene_of_model(model_path) : cameras;
  if (choice.cameras.empty()) return {};
  std::vector<NamedView> views;
  try {
    views = read_views(choice, model);
  } catch (const InputError&) {
    if (!cameras.empty()) throw;
    return {};  // nobody asked for a scene that has changed since
  }
  return rig_of_views(views, model.time_axis);
}

}  // namespace tessera
