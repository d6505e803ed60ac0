// The initial cloud of a prepared scene on disk, of the requested density: static points by a plane
// sweep at key timesteps, moving points by one at every second timestep, with velocities from the
// neighbouring timesteps. `ingest` and `train` share this code.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "ingest/capture/capture.h"
#include "ingest/cloud/cloud_frames.h"
#include "ingest/cloud/dense_cloud.h"
#include "ingest/cloud/point_velocities.h"
#include "ingest/ingest.h"
#include "kernels/pixel_search.h"

namespace tessera {

struct RigCloud {
  PointCloud points;  // with time, still and velocity
  /// At which still and moving points were looked for; 0: no three cameras share a timestep.
  int64_t key_timesteps = 0, motion_timesteps = 0;
  VelocityCount velocities;
  /// Of the pixels at the key timesteps, that change over time; measured where no point moves.
  double changing_share = 0;
  double sweep_seconds = 0, velocity_seconds = 0;
};

/// The cloud of the training frames; points that their scene has are not looked at. At most half of
/// the points move, an equal number at each of motion_timesteps(). Images of the key timesteps
/// (key_timesteps(), as many as fit into 2 GiB, 2 at least) and of three more are asked for at a
/// time. Empty when no three training cameras share a timestep. The same for any number of threads.
/// `device`: searches pixels in place of the CPU and finds the same; asked for where there is a
/// rig, and may be empty or give none. Errors: as load_scene; DeviceError.
RigCloud rig_cloud(const CloudFrames& frames, const CloudOptions& options,
                   const std::function<std::unique_ptr<PixelSearch>()>& device = {});

/// One line: how many points and timesteps, how many move, how many of these have a velocity.
std::string summary(const RigCloud& cloud);

/// A line where much changes and nothing was found that moves; else "".
std::string motion_warning(const RigCloud& cloud);

/// Adds to the points of `capture` what options.cloud asks for: the rig_cloud() of the scene in
/// `folder`, which holds transforms.json and the images. A cloud that a prepared scene brought
/// along is dense already and kept as it is. Notes and warnings are added.
void add_initial_cloud(const std::filesystem::path& folder, const IngestOptions& options,
                       const IngestProgress& progress, Capture& capture);

/// Training cameras of one timestep, at most; nothing for photos of a COLMAP model and one camera.
std::optional<int64_t> cameras_of_a_rig(const Capture& capture);

}  // namespace tessera
