// What: the cloud of a prepared scene, of the density that was asked for.
// Not: the sweep (dense_cloud.h), sparse points (colmap_model.h, point_cloud.h).
#pragma once
#include "ingest/ingest.h"
#include "ingest/layouts/prepared_scene.h"

namespace tessera {

/// Cameras of the training split that share the scene's fullest timestep; 1 for monocular captures.
int64_t cameras_of_a_timestep(const PreparedScene& scene);

/// `sparse` with what options.cloud adds. `folder` holds the scene's transforms.json and images,
/// of which those of at most 8 timesteps are in memory at a time, as many as fit into 1 GiB (2 at
/// least). A cloud that a prepared scene brought along is dense already and kept as it is.
PointCloud initial_cloud(const std::filesystem::path& folder, const PreparedScene& scene,
                         PointCloud sparse, const IngestOptions& options,
                         const IngestProgress& progress, std::vector<std::string>& warnings);

/// A line on what few cameras cost, or nothing.
void warn_of_few_cameras(const PreparedScene& scene, std::vector<std::string>& warnings);

}  // namespace tessera
