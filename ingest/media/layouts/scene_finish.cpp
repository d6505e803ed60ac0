// What: the steps in their order: world, exposure, cloud; each sees what the one before made.
// Not: the steps themselves.
#include "ingest/media/layouts/scene_finish.h"

#include <map>

#include "ingest/cloud/initial_cloud.h"
#include "ingest/files/point_cloud.h"
#include "ingest/media/images/mask_source.h"
#include "ingest/media/layouts/exposure_conversion.h"
#include "ingest/poses/world_normalisation.h"
#include "ingest/test_views.h"

namespace tessera {
namespace {

/// The training cameras, a camera that stands still once.
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

/// A transforms file states a world that protocols and other programs rely on; poses that were
/// estimated, or given in whatever world their program chose, do not.
bool has_arbitrary_world(CaptureLayout layout) {
  return layout != CaptureLayout::kTransforms;
}

}  // namespace

void finish_scene(Converted& converted, CaptureLayout layout, const std::filesystem::path& folder,
                  const IngestOptions& options, const IngestProgress& progress) {
  PreparedScene& scene = converted.scene;
  IngestReport& report = converted.report;
  check_masks(scene, options, report);
  scene.inverted_masks = options.invert_masks;
  if (!options.keep_world && has_arbitrary_world(layout)) normalise_world(converted);
  write_prepared_scene(folder, scene);  // for the next two, which look at the images
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
}

}  // namespace tessera
