// Small COLMAP models, written as binary and as text from one description. The bytes follow the
// description of the format and do not use the readers under test.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera::testing {

struct WrittenCamera {
  uint32_t id = 1;
  int32_t number = 1;  // of the model
  std::string model = "PINHOLE";
  uint64_t width = 32, height = 24;
  std::vector<double> parameters{40, 42, 16.5, 11.5};
};

struct WrittenImage {
  std::string name;
  std::array<double, 4> quaternion{1, 0, 0, 0};  // w x y z, cam_from_world
  glm::dvec3 translation{0, 0, 0};
  uint32_t camera = 1;
  int features = 2;
};

struct WrittenPoint {
  glm::dvec3 position;
  std::array<uint8_t, 3> colour;
};

struct WrittenModel {
  std::vector<WrittenCamera> cameras;
  std::vector<WrittenImage> images;
  std::vector<WrittenPoint> points;
};

/// One camera, `count` images b00.png … that stand on a circle, look at the origin and are listed
/// in reverse order; three points.
WrittenModel small_colmap_model(int count);
/// The pose of a camera that stands like this.
void stand_at(WrittenImage& image, const Stand& stand);

void write_colmap_bin(const std::filesystem::path& folder, const WrittenModel& model);
void write_colmap_txt(const std::filesystem::path& folder, const WrittenModel& model);

/// A capture: the model as .bin in sparse/0, and an image in `images` for each image, each of the
/// camera's size.
void write_photo_set(const std::filesystem::path& capture, const WrittenModel& model);

}  // namespace tessera::testing
