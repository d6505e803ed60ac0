// The records of the three files of a COLMAP model, binary or text, and the camera models (numbers
// 0–10 of COLMAP 3.8) as pinhole intrinsics and lens. Feature points are skipped, and of tracks all
// but the images of binary ones.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "ingest/poses/lens.h"
#include "ingest/scene.h"
#include "kernels/base/camera.h"
#include "kernels/base/errors.h"

namespace tessera {

struct ColmapCamera {
  std::string model;  // "OPENCV"
  Camera camera;      // size and intrinsics; no pose
  Lens lens;
  std::string unusable{};  // why no image can be of it; empty: images can
};

struct ColmapCameraModel {
  int32_t number;
  const char* name;
  const char* parameters;  // in file order, blanks between them
  Lens::Projection projection;
  size_t parameter_count() const;
};

/// Errors: InputError that starts with `where` and lists the models there are.
const ColmapCameraModel& colmap_camera_model(int32_t number, const std::string& where);
const ColmapCameraModel& colmap_camera_model(const std::string& name, const std::string& where);

/// Whether the model of this name has fx and fy. Errors: as above.
bool has_two_focal_lengths(const std::string& model);

/// Errors: InputError that starts with `where`: a size or focal length that is not positive, a
/// parameter that is not finite, another number of parameters than the model has.
ColmapCamera make_colmap_camera(const ColmapCameraModel& model, uint64_t width, uint64_t height,
                                const std::vector<double>& parameters, const std::string& where);

/// What `make` returns, or a camera that states the InputError which it throws: only images of a
/// camera that cannot be used are lost by it.
template <class Make>
ColmapCamera camera_or_reason(const Make& make) {
  try {
    return make();
  } catch (const InputError& error) {
    ColmapCamera camera;
    camera.unusable = error.what();
    return camera;
  }
}

/// The lens's parameters that are not zero, by COLMAP's names, in one fixed order.
std::vector<std::pair<const char*, double>> lens_parameters(const Lens& lens);

struct ColmapImage {
  std::string name;                    // path below the folder of the images
  std::array<double, 4> quaternion{};  // cam_from_world, w x y z, as stored
  glm::dvec3 translation{};            // of cam_from_world
  uint32_t camera = 0;                 // id
  uint32_t id = 0;                     // to which tracks refer; read from .bin alone
};

/// Errors of the points whose track has an image, pixels.
struct ImageError {
  double sum = 0;
  int64_t points = 0;
  void add(double error) {
    sum += error;
    ++points;
  }
  double mean() const { return sum / double(points); }
};
using ImageErrors = std::unordered_map<uint32_t, ImageError>;  // by the image's id

struct ColmapPoints {
  PointCloud cloud;
  double error = 0;        // mean reprojection error over the points, pixels; 0 without points
  ImageErrors by_image{};  // of .bin alone
};

using ColmapCameras = std::map<uint32_t, ColmapCamera>;  // by id

// Errors of all: InputError naming the file, the record or line, what was seen and the remedy:
// missing, truncated, longer than its records, a value that cannot be, an id listed twice.
ColmapCameras read_colmap_cameras_bin(const std::filesystem::path& path);
std::vector<ColmapImage> read_colmap_images_bin(const std::filesystem::path& path);
/// Positions less `origin`, which is subtracted in double.
ColmapPoints read_colmap_points_bin(const std::filesystem::path& path, const glm::dvec3& origin);

// The text files state their counts in a comment; another count becomes a warning.
ColmapCameras read_colmap_cameras_txt(const std::filesystem::path& path,
                                      std::vector<std::string>& warnings);
std::vector<ColmapImage> read_colmap_images_txt(const std::filesystem::path& path,
                                                std::vector<std::string>& warnings);
ColmapPoints read_colmap_points_txt(const std::filesystem::path& path, const glm::dvec3& origin,
                                    std::vector<std::string>& warnings);

/// Points in the order of their ids: COLMAP's two formats list the same points differently.
void sort_by_id(PointCloud& points, const std::vector<uint64_t>& ids);

}  // namespace tessera
