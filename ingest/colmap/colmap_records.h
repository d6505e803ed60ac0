// What: the three files of a COLMAP model, binary or text, each as a list of what it holds.
// Not: what must hold between them (colmap_model.h); tracks and feature points are passed over.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <vector>

#include "ingest/colmap/colmap_camera.h"
#include "ingest/scene.h"

namespace tessera {

struct ColmapImage {
  std::string name;                    // path below the folder of the images
  std::array<double, 4> quaternion{};  // cam_from_world, w x y z, as stored
  glm::dvec3 translation{};            // of cam_from_world
  uint32_t camera = 0;                 // id
};

using ColmapCameras = std::map<uint32_t, ColmapCamera>;  // by id

// Errors of all: InputError naming the file, the record or line, what was seen and the remedy:
// missing, truncated, longer than its records, a value that cannot be, an id listed twice.
ColmapCameras read_colmap_cameras_bin(const std::filesystem::path& path);
std::vector<ColmapImage> read_colmap_images_bin(const std::filesystem::path& path);
PointCloud read_colmap_points_bin(const std::filesystem::path& path);

// The text files state their counts in a comment; another count becomes a warning.
ColmapCameras read_colmap_cameras_txt(const std::filesystem::path& path,
                                      std::vector<std::string>& warnings);
std::vector<ColmapImage> read_colmap_images_txt(const std::filesystem::path& path,
                                                std::vector<std::string>& warnings);
PointCloud read_colmap_points_txt(const std::filesystem::path& path,
                                  std::vector<std::string>& warnings);

/// Points in the order of their ids: COLMAP's two formats list the same points differently.
void sort_by_id(PointCloud& points, const std::vector<uint64_t>& ids);

}  // namespace tessera
