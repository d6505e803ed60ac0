// Camera poses and a sparse cloud by the program `colmap`: for static rigs, for one moving camera,
// and points alone where poses are known.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/ingest.h"
#include "ingest/poses/lens.h"
#include "ingest/scene.h"
#include "ingest/video/clip_frames.h"

namespace tessera {

/// Said after what COLMAP found where it was not run.
inline constexpr const char* kReused = " (kept from an earlier command; COLMAP was not run again)";

struct PoseEstimate {
  std::vector<std::optional<RigCamera>> cameras;  // one a clip; empty where it was not registered
  std::vector<char> held_out;                     // one a clip
  PointCloud points;                              // of the training cameras only
  bool reused = false;                            // COLMAP was run for another output
  double error = 0;                               // mean reprojection error of them, pixels
  std::vector<std::string> warnings;              // one line each
};

/// Frames of one timestep: `frame[i]` is an index into clips[i].timeline.ticks.
struct RigInstant {
  double time = 0;  // normalised to [0, 1]
  std::vector<std::optional<size_t>> frame;
};

/// One pose a camera from still parts of the images. `work`: a folder that is kept and reused as
/// long as the inputs are the same. `held_out[i]`: the camera's pose is solved, but it gives no
/// points and no colours; absent: the innermost of the registered cameras. Errors: InputError: no
/// `colmap`, its failure with the log's path, too few cameras registered.
PoseEstimate estimate_rig(const std::vector<RigClip>& clips,
                          const std::optional<std::vector<char>>& held_out,
                          const std::filesystem::path& work, const PoseOptions& options,
                          const IngestProgress& progress);

/// Points of each timestep, with its time, triangulated from the known poses of the clips.
PointCloud triangulate_instants(const std::vector<RigClip>& clips,
                                const std::vector<char>& held_out,
                                const std::vector<RigInstant>& instants,
                                const std::filesystem::path& work, const PoseOptions& options,
                                const IngestProgress& progress);

struct MovingCameraModel {
  std::filesystem::path folder;  // of the COLMAP model; its images are named below `images`
  size_t images = 0;             // that it was given
  bool reused = false;           // COLMAP was run for another output
  std::vector<std::string> warnings;
};

/// Poses of the photos in a folder, or of frames of one video written there under names in the
/// order of their times (`in_order`: each is matched with its neighbours only). Images of a
/// folder share their lens unless `options` says otherwise. `work` as in estimate_rig. Errors:
/// InputError: fewer than 2 images, no `colmap`, its failure, no model, or with `strict` images
/// that were not registered.
MovingCameraModel estimate_moving_camera(const std::filesystem::path& images, bool in_order,
                                         const std::filesystem::path& work,
                                         const PoseOptions& options,
                                         const IngestProgress& progress);

}  // namespace tessera
