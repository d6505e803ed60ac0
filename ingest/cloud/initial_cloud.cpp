// What: whether a capture is a rig, and the sweep on the prepared scene where it is one.
// Not: files: points.ply is written with the scene.
// Source: scores with few cameras: failure mode B12.
#include "ingest/cloud/initial_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "ingest/clocks/timesteps.h"
#include "ingest/cloud/rig_cloud.h"
#include "ingest/files/point_cloud.h"

namespace tessera {
namespace {

constexpr int64_t kFewestCameras = 3;  // that a depth is agreed on by

std::vector<Timestep> training_timesteps(const PreparedScene& scene) {
  std::vector<FrameTime> times;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    const Frame& frame = scene.frames[i].frame;
    if (frame.split == Split::kTrain) times.push_back({frame.camera_name, frame.time, int(i)});
  }
  return group_timesteps(times);
}

/// Dense by itself for rigs; photo sets have their COLMAP points, and far too many images a
/// timestep.
CloudDensity density(const PreparedScene& scene, const PointCloud& sparse,
                     const IngestOptions& options) {
  if (scene.layout == "transforms" && !sparse.still.empty() && options.cloud != CloudDensity::kNone)
    return CloudDensity::kSparse;
  if (options.cloud) return *options.cloud;
  return scene.layout != "colmap" && cameras_of_a_timestep(scene) >= kFewestCameras
             ? CloudDensity::kDense
             : CloudDensity::kSparse;
}

}  // namespace

int64_t cameras_of_a_timestep(const PreparedScene& scene) {
  size_t most = 0;
  for (const Timestep& timestep : training_timesteps(scene)) {
    std::set<std::string> names;
    for (int i : timestep.frames) names.insert(scene.frames[size_t(i)].frame.camera_name);
    most = std::max(most, names.size());
  }
  return int64_t(most);
}

PointCloud initial_cloud(const std::filesystem::path& folder, const PreparedScene& scene,
                         PointCloud sparse, const IngestOptions& options,
                         const IngestProgress& progress, IngestReport& report) {
  switch (density(scene, sparse, options)) {
    case CloudDensity::kNone:
      return {};
    case CloudDensity::kSparse:
      return sparse;
    case CloudDensity::kDense:
      break;
  }
  CloudOptions cloud;
  cloud.points = options.cloud_points;
  cloud.progress = [&](int64_t done) { progress("initial cloud", done, options.cloud_points); };
  cloud.progress(0);
  const RigCloud found = rig_cloud(folder, cloud);
  if (found.points.position.empty())
    report.warnings.push_back(
        fmt::format("no dense cloud: {}; the training starts from {}",
                    cameras_of_a_timestep(scene) < kFewestCameras
                        ? "no three training cameras show the same timestep"
                        : "the cameras agree on the depth of no pixel, check their poses",
                    sparse.position.empty() ? "random points" : "the sparse points"));
  else
    report.notes.push_back(summary(found));
  progress("initial cloud", options.cloud_points, options.cloud_points);
  add_points(sparse, found.points);
  return sparse;
}

void warn_of_few_cameras(const PreparedScene& scene, std::vector<std::string>& warnings) {
  constexpr int64_t kFew = 6;
  const int64_t cameras = cameras_of_a_timestep(scene);
  const bool monocular = scene.layout == "transforms" ? cameras < 2 : scene.cameras.size() < 2;
  if (scene.layout == "colmap" || monocular || cameras >= kFew) return;
  warnings.push_back(fmt::format(
      "{} training camera{}: new views will be poor; published methods lose 10 to 14 dB "
      "on N3DV with 4 cameras instead of all; {} or more are advised",
      cameras, cameras == 1 ? "" : "s", kFew));
}

}  // namespace tessera
