// The last step, after the images are written: world normalisation, exposure, the initial cloud and
// the description of the scene.
#include <fmt/format.h>

#include <map>

#include "ingest/checks/camera_table.h"
#include "ingest/checks/camera_warnings.h"
#include "ingest/checks/exposure.h"
#include "ingest/checks/rig_spacing.h"
#include "ingest/cloud/initial_cloud.h"
#include "ingest/derived/thinned_scene.h"
#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/poses/world_normalisation.h"
#include "ingest/prepared/prepared_scene.h"
#include "ingest/steps/prepared_image.h"
#include "ingest/steps/steps.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// The training cameras, with a static camera once.
std::vector<Camera> training_poses(const Capture& scene) {
  std::vector<Camera> poses;
  std::map<std::string, Camera> last;  // by camera name
  for (const CaptureFrame& prepared : scene.frames) {
    const Frame& frame = prepared.frame;
    if (frame.split != Split::kTrain) continue;
    const auto [at, is_new] = last.try_emplace(frame.camera_name, frame.camera);
    if (!is_new && equal_pose(at->second, frame.camera)) continue;
    at->second = frame.camera;
    poses.push_back(frame.camera);
  }
  return poses;
}

void change_world(const Similarity& change, Capture& capture) {
  for (CaptureFrame& frame : capture.frames)
    frame.frame.camera = camera_in_world(change, frame.frame.camera);
  move_points(change, capture.points);
  capture.prepared_from_source = compose(change, capture.prepared_from_source);
}

/// A world that is arbitrary is normalised, a stated one made usable; a world that is to be kept
/// has only lost its far origin.
void place_world(const IngestOptions& options, Capture& capture) {
  const bool is_stated = row_of(*options.layout).stated_world;
  const std::vector<Camera> poses = training_poses(capture);
  if (!options.keep_world && !poses.empty())
    change_world(is_stated ? usable_from_stated(poses, capture.points)
                           : normalised_from_source(poses, capture.points),
                 capture);
  const std::string line = stated_world_text(capture.prepared_from_source);
  if ((options.keep_world || is_stated) && !capture.stated_axis && !line.empty())
    capture.notes.push_back(line);
}

using Gains = std::map<std::string, std::array<double, 3>>;  // by camera

Gains gains_of(const Scene& sample) {
  const std::vector<Station> stations = training_stations(sample);
  if (stations.size() < 2)
    throw InputError("--fit-exposure compares cameras, and there is one; leave it out");
  for (const Station& station : stations)
    if (station.name != sample.frames[size_t(station.frames.front())].camera_name)
      throw InputError(
          fmt::format("--fit-exposure compares cameras that stand still, and '{}' moves; leave it "
                      "out",
                      sample.frames[size_t(station.frames.front())].camera_name));
  Gains gains;
  for (const CameraGain& camera : fit_exposure(match_stations(sample)))
    gains[camera.camera] = camera.gain;
  return gains;
}

/// `folder` holds the scene as written. Rewrites the images of training cameras and records the
/// gains in `scene` (1 for held-out cameras). Errors: InputError: fewer than two training cameras,
/// or one with several poses.
void even_exposure(const std::filesystem::path& folder, Capture& scene,
                   const IngestProgress& progress) {
  Thinning thinning;
  thinning.stations = int(scene.frames.size());  // all
  const Gains gains = gains_of(thinned_scene(folder, thinning).sample);
  for (CaptureCamera& camera : scene.cameras) {
    const auto found = gains.find(camera.name);
    camera.exposure_gain = found == gains.end() ? std::array<double, 3>{1, 1, 1} : found->second;
  }
  convert_images(scene.frames.size(), progress, [&](size_t i) {
    const CaptureFrame& prepared = scene.frames[i];
    const auto found = gains.find(prepared.frame.camera_name);
    if (prepared.frame.split != Split::kTrain || found == gains.end()) return;
    Image8 image = read_png(folder / prepared.file_path);
    apply_exposure(image, found->second);
    write_png(folder / prepared.file_path, image);
  });
}

/// By a few small frames of each camera.
void warn_of_odd_cameras(const std::filesystem::path& folder, Capture& capture) {
  const ThinnedScene thinned =
      thinned_scene(folder, {.instants = 3, .stations = 40, .largest = 640});
  const std::vector<std::string> odd =
      camera_warnings(thinned.all, thinned.sample, capture.camera_table);
  capture.warnings.insert(capture.warnings.end(), odd.begin(), odd.end());
}

/// New views of a rig of few cameras.
void say_what_to_expect(Capture& capture) {
  if (!cameras_of_a_rig(capture)) return;
  std::map<std::string, Station> training;
  bool held_out = false;
  for (const CaptureFrame& prepared : capture.frames) {
    const Frame& frame = prepared.frame;
    held_out |= frame.split == Split::kTest;
    if (frame.split == Split::kTrain)
      training[frame.camera_name] = {frame.camera_name, frame.camera, frame.split, {}};
  }
  std::vector<Station> stations;
  for (const auto& [name, station] : training) stations.push_back(station);
  const std::optional<Finding> expected = expected_views(stations, held_out && !capture.is_static);
  if (!expected) return;
  const bool warns = expected->severity == Severity::kWarning;
  (warns ? capture.warnings : capture.notes)
      .push_back(expected->measured + "; " + expected->advice);
}

}  // namespace

Capture finish_scene(Capture capture, const StepContext& context) {
  const IngestOptions& options = context.options;
  const std::filesystem::path& folder = context.folder;
  place_world(options, capture);
  write_prepared_scene(folder, capture);  // read by the next two
  if (options.fit_exposure) even_exposure(folder, capture, context.progress);
  add_initial_cloud(folder, options, context.progress, capture);
  say_what_to_expect(capture);
  capture.has_points = !capture.points.position.empty();
  if (capture.has_points) write_points(folder / "points.ply", capture.points);
  write_prepared_scene(folder, capture);
  capture.camera_table = camera_table(capture);
  if (options.check_cameras && capture.cameras.size() > 1 && row_of(*options.layout).clips)
    warn_of_odd_cameras(folder, capture);
  if (const std::string line = leave_out_line(capture.camera_table); !line.empty())
    capture.warnings.insert(capture.warnings.begin(), line);  // below the table
  return capture;
}

}  // namespace tessera
