// What: the initial cloud of a rig whose scene lies on disk: the plane sweep at key timesteps, and
//       velocities from the timesteps beside them. `ingest` and `train` both make it by this.
// Not: whether a capture gets one (initial_cloud.h), and no files are written.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "ingest/cloud/dense_cloud.h"
#include "ingest/cloud/point_velocities.h"

namespace tessera {

struct RigCloud {
  PointCloud points;          // with time, still and velocity
  int64_t key_timesteps = 0;  // that the sweep looked at; 0: no three cameras share one
  VelocityCount velocities;
  double sweep_seconds = 0, velocity_seconds = 0;
};

/// The cloud of the training frames of the scene in `folder`, which load_scene can read; its own
/// points are not looked at. Images of the key timesteps (key_timesteps(), as many as fit into
/// 2 GiB, 2 at least) and of two more are in memory at a time. Empty when no three training cameras
/// share a timestep. The same for any number of threads. Errors: as load_scene.
RigCloud rig_cloud(const std::filesystem::path& folder, const CloudOptions& options);

/// One line: how many points and timesteps, how many move, how many of these have a velocity.
std::string summary(const RigCloud& cloud);

}  // namespace tessera
