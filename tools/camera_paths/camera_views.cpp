// Reads views from a scene or a transforms file, and converts their times and poses to the world of
// the model.
#include "tools/camera_paths/camera_views.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/files/png.h"
#include "ingest/images/image_paths.h"
#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"
#include "tools/camera_paths/export_times.h"
#include "tools/session/model_scene.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Normalised time of `axis` → normalised time of the model, through the capture's own clock; where
/// the model's file has no clock, both are of the whole clip.
double model_time(const GaussianModel& model, const TimeAxis& axis, double time) {
  const TimeAxis& model_axis = model.time_axis;
  if (!model_axis.is_stated) return time;
  if (axis.origin == model_axis.origin && axis.duration == model_axis.duration) return time;
  return (axis.origin + time * axis.duration - model_axis.origin) / model_axis.duration;
}

/// A duration of `axis` in the model's time.
double model_duration(const GaussianModel& model, const TimeAxis& axis, double duration) {
  const double length = model.time_axis.is_stated ? model.time_axis.duration : axis.duration;
  return axis.duration == length ? duration : duration * axis.duration / length;
}

/// A camera of a file into the model's world. A prepared scene states how its world comes from the
/// source's (`prepared_from_source`); any other file is in the source's world: the identity.
Camera model_camera(const GaussianModel& model, const Similarity& prepared_from_source,
                    const Camera& camera) {
  if (prepared_from_source == model.prepared_from_source) return camera;
  return camera_in_world(compose(model.prepared_from_source, inverse(prepared_from_source)),
                         camera);
}

/// The same for images that are shown: of one instant, whatever the shutter.
Camera shown_camera(const GaussianModel& model, const Similarity& prepared_from_source,
                    const Camera& camera) {
  Camera shown = model_camera(model, prepared_from_source, camera);
  shown.readout = 0;
  return shown;
}

std::vector<NamedView> views_of_scene(const CameraChoice& choice, const GaussianModel& model) {
  const Scene scene = scene_without_pixels(choice.cameras, true);
  std::vector<NamedView> views;
  for (const Frame& frame : scene.frames) {
    if (!choice.split.empty() && frame.split != parse_split(choice.split)) continue;
    const double time = choice.time.value_or(model_time(model, scene.time_axis, frame.time));
    views.push_back(
        {frame.name, {shown_camera(model, scene.prepared_from_source, frame.camera), time}});
  }
  return views;
}

/// Width and height as stated, else of the image.
Image8 size_of(const TransformsFrame& frame, const fs::path& folder) {
  if (frame.intrinsics.w && frame.intrinsics.h)
    return {*frame.intrinsics.w, *frame.intrinsics.h, 3, {}};
  try {
    return read_png_size(require_image(folder, frame.name, frame.where));
  } catch (const InputError&) {
    throw InputError(fmt::format(
        "{}: states no w and h, and its image is no PNG beside it; add w and h", frame.where));
  }
}

double time_of(const KeyFrame& key, const CameraChoice& choice, const GaussianModel& model) {
  if (choice.time) return *choice.time;
  if (key.time || !model.moves()) return key.time.value_or(0);
  throw InputError(
      fmt::format("{}: has no time and the model moves; add it or pass --time", key.where));
}

std::vector<NamedView> views_of_path(const CameraChoice& choice, const GaussianModel& model) {
  std::vector<NamedView> views;
  for (const KeyFrame& key : read_key_frames(choice.cameras, choice.split, model))
    views.push_back({key.name, {key.camera, time_of(key, choice, model)}});
  return views;
}

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

std::vector<NamedView> find_views(const CameraChoice& choice, const GaussianModel& model) {
  if (!fs::exists(choice.cameras))
    throw InputError(
        fmt::format("{}: no such file or folder; expected a scene or a transforms.json",
                    choice.cameras.string()));
  return fs::is_directory(choice.cameras) ? views_of_scene(choice, model)
                                          : views_of_path(choice, model);
}

std::vector<NamedView> read_views(const CameraChoice& choice, const GaussianModel& model) {
  std::vector<NamedView> views = find_views(choice, model);
  if (views.empty())
    throw InputError(fmt::format("{}: no frame in split '{}'; choose another of train, val, test",
                                 choice.cameras.string(), choice.split));
  return views;
}

std::vector<KeyFrame> read_key_frames(const fs::path& file, const std::string& split,
                                      const GaussianModel& model) {
  const TransformsCapture path = read_camera_path(file);
  std::vector<KeyFrame> keys;
  for (const TransformsFrame& frame : path.frames) {
    if (!split.empty() && frame.split != parse_split(split)) continue;
    Camera camera = frame.camera;
    const Image8 size = size_of(frame, file.parent_path());
    set_intrinsics(camera, frame.intrinsics, size.width, size.height, frame.where);
    KeyFrame key{
        frame.name, frame.where, shown_camera(model, path.prepared_from_source, camera), {}};
    // A prepared scene states normalised times, any other file those of the capture's own clock.
    if (frame.time)
      key.time = model_time(model, path.prepared_axis.value_or(TimeAxis{}), *frame.time);
    keys.push_back(std::move(key));
  }
  return keys;
}

Split parse_split(const std::string& name) {
  if (name == "train") return Split::kTrain;
  if (name == "val") return Split::kVal;
  if (name == "test") return Split::kTest;
  throw InputError(fmt::format("unknown split '{}'; choose train, val or test", name));
}

Scene scene_for(const GaussianModel& model, const fs::path& model_path, const fs::path& path,
                SceneOptions options) {
  if (!options.window) options.window = core_of_model(model_path, path);
  options.background = model.background;
  options.allow_static = true;
  Scene scene = load_scene(path, options);
  for (Frame& frame : scene.frames) {
    frame.time = model_time(model, scene.time_axis, frame.time);
    frame.camera = model_camera(model, scene.prepared_from_source, frame.camera);
    frame.camera.readout = model_duration(model, scene.time_axis, frame.camera.readout);
  }
  return scene;
}

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
    return {};  // a scene that has changed since is not required
  }
  return rig_of_views(views, model.time_axis);
}

}  // namespace tessera
