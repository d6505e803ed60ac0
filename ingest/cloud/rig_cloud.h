// The initial cloud of a rig whose scene lies on disk: what stands still by a plane sweep at key
// timesteps, what moves by one at every second timestep, with velocities from the timesteps beside
// it. `ingest` and `train` both make it by this.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "ingest/cloud/dense_cloud.h"
#include "ingest/cloud/point_velocities.h"

namespace tessera {

struct RigCloud {
  PointCloud points;  // with time, still and velocity
  /// At which still and moving points were looked for; 0: no three cameras share a timestep.
  int64_t key_timesteps = 0, motion_timesteps = 0;
  VelocityCount velocities;
  double sweep_seconds = 0, velocity_seconds = 0;
};

/// The cloud of the training frames of the scene in `folder`, which load_scene can read; its own
/// points are not looked at. At most half of the points move, an equal number at each of
/// motion_timesteps(). Images of the key timesteps (key_timesteps(), as many as fit into 2 GiB, 2
/// at least) and of three more are in memory at a time. Empty when no three training cameras share
/// a timestep. The same for any number of threads. Errors: as load_scene.
RigCloud rig_cloud(const std::filesystem::path& folder, const CloudOptions& options);

/// One line: how many points and timesteps, how many move, how many of these have a velocity.
std::string summary(const RigCloud& cloud);

}  // namespace tessera
