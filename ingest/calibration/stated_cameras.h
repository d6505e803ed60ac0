// The cameras of a rig's clips where a calibration states them: the one that is named, or one that
// lies in the capture and fits.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/ingest.h"
#include "ingest/poses/lens.h"
#include "ingest/scene.h"

namespace tessera {

struct StatedCameras {
  std::filesystem::path path;                     // the calibration, for messages
  std::vector<std::optional<RigCamera>> cameras;  // one a clip, called as the clip
  std::vector<std::string> stated_names;          // of all cameras of the calibration
  bool by_row = false;                            // poses_bounds.npy: N3DV or LLFF
  PointCloud points;                              // in their world; may be empty
  glm::dvec3 origin{0};                           // taken out of cameras and points already
  std::vector<std::filesystem::path> files;       // that were read
  std::vector<std::string> notes;  // "poses of 6 cameras from sparse_ (COLMAP model)" where it is
                                   // found, and keys that are not read
};

/// The calibration `source` (kCameras, or kN3dv or kLlff: poses_bounds.npy in `capture`), or what
/// is found in `capture`: where it is kFound, poses_bounds.npy, a COLMAP model in one of
/// colmap_models_in(), intri.yml and extri.yml; where it is kColmap, a model alone. The first is
/// taken that has a camera for each of `wanted` (all of `clips` where it is empty); those before it
/// are warned of, and so are other files that seem to be calibrations, where `source` is kFound.
/// `clips` are the names of all clips, sorted. Nothing where none is taken. Errors: InputError: a
/// named calibration, or poses_bounds.npy, that cannot be read or has cameras for no clip or, by
/// row, for another number of them.
std::optional<StatedCameras> stated_cameras(const std::filesystem::path& capture,
                                            const PoseSource& source,
                                            const std::vector<std::string>& clips,
                                            const std::vector<std::string>& wanted,
                                            std::vector<std::string>& warnings);

}  // namespace tessera
