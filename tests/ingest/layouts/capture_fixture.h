// Shared parts of the ingest tests: temporary folders, small captures and the place of real data.
// Captures are written by hand from the conventions and do not use the code under test.
#pragma once
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "ingest/prepared/scene_reader.h"
#include "ingest/scene.h"
#include "kernels/base/errors.h"

namespace tessera::testing {

/// A folder that is removed with the test.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// An image in which every pixel and channel differs from its neighbours.
Image8 patterned_image(int width, int height, int channels, int seed = 0);
Image8 constant_image(int width, int height, const std::vector<uint8_t>& pixel);
/// Red and green are the pixel's column and row.
Image8 ramp(int width, int height);

/// Where a camera stands and how it is turned, from first principles.
struct Stand {
  glm::dvec3 centre, right, up, forward;
};
/// A camera at `centre` that looks at the origin with +z up.
Stand looking_at_origin(const glm::dvec3& centre);
/// Camera-to-world in OpenGL axes: columns right, up, −forward, centre.
nlohmann::json gl_matrix(const Stand& stand);

struct SmallCapture {
  int train = 4, test = 2;  // frames a split; a split of 0 has no file
  int width = 8, height = 6, channels = 4;
  bool with_times = true;
  std::function<double(double)> time = [](double t) { return t; };  // applied to i / (train − 1)
};
/// Writes a D-NeRF capture below `folder`; cameras stand on a circle.
void write_dnerf(const std::filesystem::path& folder, const SmallCapture& capture);
/// Reads, changes and writes a JSON file.
void edit_json(const std::filesystem::path& path,
               const std::function<void(nlohmann::json&)>& change);
void write_bytes(const std::filesystem::path& path, const std::string& bytes);
std::string read_bytes(const std::filesystem::path& path);

/// The InputError message of `action`; fails the test when there is none, when it is not one line,
/// or when it lacks one of `parts`.
void expect_input_error(const std::function<void()>& action, const std::vector<std::string>& parts);

/// The folder of real captures (environment variable TESSERA_DATA, else ../shared/data beside or
/// above the sources), if it has `name`.
std::optional<std::filesystem::path> real_data(const std::string& name);

/// Pixel coordinates of a world point.
glm::dvec2 project(const Camera& camera, const glm::dvec3& point);
/// Direction in world space of the ray through a pixel position.
glm::dvec3 ray_through(const Camera& camera, double x, double y);
void expect_same_camera(const Camera& one, const Camera& other, double tolerance);

}  // namespace tessera::testing

#define TESSERA_NEED_DATA(variable, name)                                     \
  const auto variable##_found = ::tessera::testing::real_data(name);          \
  if (!variable##_found) GTEST_SKIP() << "no " << name << " in TESSERA_DATA"; \
  const std::filesystem::path& variable = *variable##_found
