// What: the cloud of a prepared scene, of the density that was asked for.
// Not: the sweep (rig_cloud.h), sparse points (colmap_model.h, point_cloud.h).
#pragma once
#include "ingest/ingest.h"
#include "ingest/prepared/prepared_scene.h"

namespace tessera {

/// Cameras of the training split that share the scene's fullest timestep; 1 for monocular captures.
int64_t cameras_of_a_timestep(const PreparedScene& scene);

/// `sparse` with what options.cloud adds: the rig_cloud() of the scene in `folder`, which holds
/// transforms.json and the images. A cloud that a prepared scene brought along is dense already and
/// kept as it is. Notes and warnings of it are added to `report`.
PointCloud initial_cloud(const std::filesystem::path& folder, const PreparedScene& scene,
                         PointCloud sparse, const IngestOptions& options,
                         const IngestProgress& progress, IngestReport& report);

/// A line on what few cameras cost, or nothing.
void warn_of_few_cameras(const PreparedScene& scene, std::vector<std::string>& warnings);

}  // namespace tessera
