// The shared parts of the ingest tests, independent of the writers and the pose code under test.
#include "tests/ingest/layouts/capture_fixture.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>

#include "ingest/files/png.h"

namespace tessera::testing {

using nlohmann::json;

TemporaryFolder::TemporaryFolder() {
  static std::atomic<int> counter{0};
  path_ = std::filesystem::temp_directory_path() /
          fmt::format("tessera_ingest_{}_{}", ::getpid(), counter++);
  std::filesystem::create_directories(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Image8 patterned_image(int width, int height, int channels, int seed) {
  Image8 image{width, height, channels, {}};
  for (int i = 0; i < width * height * channels; ++i)
    image.data.push_back(uint8_t(i * 37 + seed * 11 + i / 7));
  return image;
}

Image8 ramp(int width, int height) {
  Image8 image{width, height, 3, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.data.insert(image.data.end(), {uint8_t(x), uint8_t(y), 7});
  return image;
}

Image8 constant_image(int width, int height, const std::vector<uint8_t>& pixel) {
  Image8 image{width, height, int(pixel.size()), {}};
  for (int i = 0; i < width * height; ++i)
    image.data.insert(image.data.end(), pixel.begin(), pixel.end());
  return image;
}

Stand looking_at_origin(const glm::dvec3& centre) {
  Stand stand{centre, {}, {}, glm::normalize(-centre)};
  stand.right = glm::normalize(glm::cross(stand.forward, glm::dvec3(0, 0, 1)));
  stand.up = glm::cross(stand.right, stand.forward);
  return stand;
}

json gl_matrix(const Stand& stand) {
  json rows = json::array();
  for (int r = 0; r < 3; ++r)
    rows.push_back({stand.right[r], stand.up[r], -stand.forward[r], stand.centre[r]});
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

void write_dnerf(const std::filesystem::path& folder, const SmallCapture& capture) {
  for (const auto& [split, count] : {std::pair{"train", capture.train}, {"test", capture.test}}) {
    if (count == 0) continue;
    json file{{"camera_angle_x", 0.7}, {"frames", json::array()}};
    std::filesystem::create_directories(folder / split);
    for (int i = 0; i < count; ++i) {
      const double angle = 0.5 * i + (split == std::string("test") ? 0.2 : 0.0);
      const Stand stand = looking_at_origin({4 * std::cos(angle), 4 * std::sin(angle), 1});
      json frame{{"file_path", fmt::format("./{}/r_{:03}", split, i)},
                 {"transform_matrix", gl_matrix(stand)}};
      if (capture.with_times) frame["time"] = capture.time(count > 1 ? i / double(count - 1) : 0.0);
      file["frames"].push_back(frame);
      write_png(folder / split / fmt::format("r_{:03}.png", i),
                patterned_image(capture.width, capture.height, capture.channels, i));
    }
    write_bytes(folder / fmt::format("transforms_{}.json", split), file.dump(1));
  }
}

void edit_json(const std::filesystem::path& path, const std::function<void(json&)>& change) {
  json file = json::parse(read_bytes(path));
  change(file);
  write_bytes(path, file.dump(1));
}

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void expect_input_error(const std::function<void()>& action,
                        const std::vector<std::string>& parts) {
  try {
    action();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& part : parts)
      EXPECT_NE(message.find(part), std::string::npos) << "no '" << part << "' in: " << message;
    return;
  } catch (const std::exception& error) {
    FAIL() << "not an InputError: " << error.what();
  }
  FAIL() << "no error; expected one that names " << (parts.empty() ? "the input" : parts.front());
}

std::optional<std::filesystem::path> real_data(const std::string& name) {
  if (const char* stated = std::getenv("TESSERA_DATA"); stated != nullptr) {
    const auto path = std::filesystem::path(stated) / name;
    return std::filesystem::exists(path) ? std::optional(path) : std::nullopt;
  }
  for (auto folder = std::filesystem::absolute(__FILE__).parent_path(); folder.has_relative_path();
       folder = folder.parent_path())
    if (const auto path = folder / "shared" / "data" / name; std::filesystem::exists(path))
      return path;
  return std::nullopt;
}

glm::dvec2 project(const Camera& camera, const glm::dvec3& point) {
  const glm::dvec3 seen = camera.cam_from_world * point + camera.translation;
  return {camera.fl_x * seen.x / seen.z + camera.cx, camera.fl_y * seen.y / seen.z + camera.cy};
}

glm::dvec3 ray_through(const Camera& camera, double x, double y) {
  const glm::dvec3 seen((x - camera.cx) / camera.fl_x, (y - camera.cy) / camera.fl_y, 1);
  return glm::normalize(glm::transpose(camera.cam_from_world) * seen);
}

void expect_same_camera(const Camera& one, const Camera& other, double tolerance) {
  EXPECT_EQ(one.width, other.width);
  EXPECT_EQ(one.height, other.height);
  EXPECT_NEAR(one.fl_x, other.fl_x, tolerance * one.fl_x);
  EXPECT_NEAR(one.fl_y, other.fl_y, tolerance * one.fl_y);
  EXPECT_NEAR(one.cx, other.cx, tolerance * one.width);
  EXPECT_NEAR(one.cy, other.cy, tolerance * one.height);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(one.translation[c], other.translation[c], tolerance);
    for (int r = 0; r < 3; ++r)
      EXPECT_NEAR(one.cam_from_world[c][r], other.cam_from_world[c][r], tolerance);
  }
}

}  // namespace tessera::testing
