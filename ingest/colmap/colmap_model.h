// Reads a COLMAP model (sparse/0 or sparse, .bin or .txt) as posed photos and an initial cloud.
// Image sizes are those of the model.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/poses/lens.h"
#include "ingest/scene.h"

namespace tessera {

struct ColmapPhoto {
  std::string name;        // path below the folder of the images, with extension; unique
  Camera camera;           // in the size of the model's camera
  Lens lens;               // what the image has beyond the pinhole
  std::string lens_model;  // COLMAP's name of it: "OPENCV"
  /// Mean reprojection error of the points that the image is in the tracks of, pixels; absent where
  /// there are none, and of text models.
  std::optional<double> error{};
};

/// Poses and points are less `origin`, so that points keep their places as floats.
struct ColmapModel {
  std::vector<std::filesystem::path> files;  // that were read
  std::vector<ColmapPhoto> photos;           // sorted by name; never empty
  PointCloud points;                         // finite; empty where there is no points3D file
  glm::dvec3 origin{0};                      // far_origin() of the photos
  double error = 0;                          // mean reprojection error of the points, pixels
  std::vector<std::string> warnings;         // one line each
};

/// The folders at most four levels below `capture` that hold a list of cameras and one of images,
/// in any case: those in `sparse` first, the one with the longest list of images before others,
/// `capture` itself last. Folders that hold images, or a folder `images`, are captures of their
/// own.
std::vector<std::filesystem::path> colmap_models_in(const std::filesystem::path& capture);

/// The first of these; `capture` itself only where it holds images, too. An empty path where there
/// is none.
std::filesystem::path find_colmap_model(const std::filesystem::path& capture);

/// Reads the .bin files of `folder`, the .txt files where those are absent. Errors: InputError
/// naming file and remedy: as of the files, no images, an image listed twice or of a camera that is
/// not there, a pose that is no pose.
ColmapModel read_colmap_model(const std::filesystem::path& folder);
/// The model of a capture. Errors: as above, and where there is none; they name --poses llff where
/// the capture has a poses_bounds.npy, too.
ColmapModel read_capture_model(const std::filesystem::path& capture);

}  // namespace tessera
