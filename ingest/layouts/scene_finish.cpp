// The last steps of every conversion, after the images are written: masks, world normalisation,
// exposure, the initial cloud and the description of the scene.

#include <fmt/format.h>

#include <map>

#include "ingest/checks/camera_warnings.h"
#include "ingest/checks/exposure.h"
#include "ingest/cloud/initial_cloud.h"
#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/layouts/conversion.h"
#include "ingest/layouts/mask_source.h"
#include "ingest/layouts/thinned_scene.h"
#include "ingest/poses/world_normalisation.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// The training cameras, with a static camera once.
std::vector<Camera> training_poses(const PreparedScene& scene) {
  std::vector<Camera> poses;
  std::map<std::string, Camera> last;  // by camera name
  for (const PreparedFrame& prepared : scene.frames) {
    const Frame& frame = prepared.frame;
    if (frame.split != Split::kTrain) continue;
    const auto [at, is_new] = last.try_emplace(frame.camera_name, frame.camera);
    if (!is_new && equal_pose(at->second, frame.camera)) continue;
    at->second = frame.camera;
    poses.push_back(frame.camera);
  }
  return poses;
}

/// Poses and points to the normalised world, if there is a training camera.
void normalise_world(Converted& converted) {
  PreparedScene& scene = converted.scene;
  const std::vector<Camera> poses = training_poses(scene);
  if (poses.empty()) return;
  const Similarity change = normalised_from_source(poses, converted.points);
  for (PreparedFrame& prepared : scene.frames)
    prepared.frame.camera = camera_in_world(change, prepared.frame.camera);
  for (glm::vec3& point : converted.points.position) point = glm::vec3(change(glm::dvec3(point)));
  for (glm::vec3& velocity : converted.points.velocity)
    velocity = glm::vec3(change.scale * (change.rotation * glm::dvec3(velocity)));
  scene.prepared_from_source = compose(change, scene.prepared_from_source);
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
void even_exposure(const std::filesystem::path& folder, PreparedScene& scene,
                   const IngestProgress& progress) {
  Thinning thinning;
  thinning.stations = int(scene.frames.size());  // all
  const Gains gains = gains_of(thinned_scene(folder, thinning).sample);
  for (PreparedCamera& camera : scene.cameras) {
    const auto found = gains.find(camera.name);
    camera.exposure_gain = found == gains.end() ? std::array<double, 3>{1, 1, 1} : found->second;
  }
  convert_images(scene.frames.size(), progress, [&](size_t i) {
    const PreparedFrame& prepared = scene.frames[i];
    const auto found = gains.find(prepared.frame.camera_name);
    if (prepared.frame.split != Split::kTrain || found == gains.end()) return;
    Image8 image = read_png(folder / prepared.file_path);
    apply_exposure(image, found->second);
    write_png(folder / prepared.file_path, image);
  });
}

/// By a few small frames of each camera.
void warn_of_odd_cameras(const std::filesystem::path& folder, std::vector<std::string>& warnings) {
  const ThinnedScene thinned =
      thinned_scene(folder, {.instants = 3, .stations = 40, .largest = 640});
  const std::vector<std::string> odd = camera_warnings(thinned.all, thinned.sample);
  warnings.insert(warnings.end(), odd.begin(), odd.end());
}

}  // namespace

void finish_scene(Converted& converted, CaptureLayout layout, const std::filesystem::path& folder,
                  const IngestOptions& options, const IngestProgress& progress) {
  PreparedScene& scene = converted.scene;
  IngestReport& report = converted.report;
  check_masks(scene, options, report);
  scene.inverted_masks = options.invert_masks;
  if (!options.keep_world && !row_of(layout).stated_world) normalise_world(converted);
  write_prepared_scene(folder, scene);  // read by the next two steps
  if (options.fit_exposure) even_exposure(folder, scene, progress);
  converted.points =
      initial_cloud(folder, scene, std::move(converted.points), options, progress, report);
  warn_of_few_cameras(scene, report.warnings);
  report.points = int64_t(converted.points.position.size());
  TestViews test_views;
  for (const PreparedFrame& prepared : scene.frames) test_views.add(prepared.frame);
  report.test_views = test_views.count();
  report.scored = test_views.text();
  scene.has_points = report.points > 0;
  if (scene.has_points) write_points(folder / "points.ply", converted.points);
  write_prepared_scene(folder, scene);
  if (options.check_cameras && report.cameras > 1 && row_of(layout).clips)
    warn_of_odd_cameras(folder, report.warnings);
}

}  // namespace tessera
