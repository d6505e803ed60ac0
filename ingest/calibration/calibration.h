// Reads the calibration of a rig, in any form in which programs leave it, as named cameras.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/poses/lens.h"
#include "ingest/scene.h"

namespace tessera {

struct Calibration {
  std::filesystem::path path;        // the file or folder that was read
  std::string form{};                // "COLMAP model", for people
  std::vector<RigCamera> cameras{};  // never empty; width 0: no size is stated
  bool by_row = false;               // they have no names, but the order of the clips' names
  PointCloud points{};               // in the world of the cameras; may be empty
  std::vector<std::filesystem::path> files{};    // that were read
  std::vector<std::string> warnings{}, notes{};  // one line each
  glm::dvec3 origin{0};                          // taken out of cameras and points already
};

/// The forms that read_calibration knows, for messages.
inline constexpr const char* kCalibrationForms =
    "a COLMAP model (its folder or one of its files), JSON of cameras (transforms.json too), "
    "OpenCV's .yml, .xml or .json (one a camera in a folder, or intri.yml and extri.yml), or "
    "poses_bounds.npy";

/// Reads `path`:
/// - a COLMAP model: a folder with cameras.bin or cameras.txt, one of its files, or the first of
///   colmap_models_in() of a folder; a camera is called as its image;
/// - .json (rig_poses_file.h), also as cv::FileStorage writes it;
/// - .yml, .yaml, .xml of cv::FileStorage with one camera, called as the file; intri and extri of
///   EasyMocap by either of them or by their folder;
/// - a folder with poses_bounds.npy, transforms.json or files of one camera each, in this order;
/// - .npy: poses_bounds.npy.
/// Errors: InputError naming the file, the camera and what is wrong with it, or the forms that are
/// read.
Calibration read_calibration(const std::filesystem::path& path);

/// intri.yml and extri.yml, or .yaml, in `folder`; both empty where one is missing.
struct EasyMocapFiles {
  std::filesystem::path intri, extri;
};
EasyMocapFiles find_easymocap(const std::filesystem::path& folder);

}  // namespace tessera
