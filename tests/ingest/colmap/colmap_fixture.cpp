// Writers of small COLMAP models with made-up ids and tracks. Source: the file formats of COLMAP
// 3.8.
#include "tests/ingest/colmap/colmap_fixture.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstring>
#include <glm/gtc/quaternion.hpp>

#include "ingest/files/png.h"

namespace tessera::testing {
namespace {

class Bytes {
 public:
  template <class T>
  Bytes& put(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Bytes& put(const glm::dvec3& value) { return put(value.x).put(value.y).put(value.z); }
  Bytes& put_name(const std::string& name) {
    text_.append(name.c_str(), name.size() + 1);
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace

void stand_at(WrittenImage& image, const Stand& stand) {
  const glm::dmat3 world_from_cam(stand.right, -stand.up, stand.forward);
  const glm::dquat q = glm::quat_cast(glm::transpose(world_from_cam));
  image.quaternion = {q.w, q.x, q.y, q.z};
  image.translation = -(glm::transpose(world_from_cam) * stand.centre);
}

WrittenModel small_colmap_model(int count) {
  WrittenModel model;
  model.cameras.push_back({});
  for (int i = count - 1; i >= 0; --i) {
    WrittenImage image;
    image.name = fmt::format("b{:02}.png", i);
    stand_at(image, looking_at_origin({5 * std::cos(0.3 * i), 5 * std::sin(0.3 * i), 1}));
    image.features = i;
    model.images.push_back(image);
  }
  model.points = {
      {{1, 2, 3}, {10, 20, 30}}, {{-0.125, 0.5, 2.25}, {255, 0, 128}}, {{4, -5, 6}, {1, 2, 3}}};
  return model;
}

void write_colmap_bin(const std::filesystem::path& folder, const WrittenModel& model) {
  std::filesystem::create_directories(folder);
  Bytes cameras, images, points;
  cameras.put(uint64_t(model.cameras.size()));
  for (const WrittenCamera& camera : model.cameras) {
    cameras.put(camera.id).put(camera.number).put(camera.width).put(camera.height);
    for (const double parameter : camera.parameters) cameras.put(parameter);
  }
  images.put(uint64_t(model.images.size()));
  uint32_t id = 0;  // points are seen by images 0 and 2
  for (const WrittenImage& image : model.images) {
    images.put(id++);
    for (const double value : image.quaternion) images.put(value);
    images.put(image.translation).put(image.camera).put_name(image.name);
    images.put(uint64_t(image.features));
    for (int i = 0; i < image.features; ++i) images.put(1.5 * i).put(2.5).put(int64_t(-1));
  }
  points.put(uint64_t(model.points.size()));
  for (const WrittenPoint& point : model.points) {
    points.put(uint64_t(9)).put(point.position);
    for (const uint8_t value : point.colour) points.put(value);
    points.put(0.5).put(uint64_t(2));
    for (uint32_t i = 0; i < 4; ++i) points.put(i);
  }
  write_bytes(folder / "cameras.bin", cameras.text());
  write_bytes(folder / "images.bin", images.text());
  write_bytes(folder / "points3D.bin", points.text());
}

void write_colmap_txt(const std::filesystem::path& folder, const WrittenModel& model) {
  std::filesystem::create_directories(folder);
  std::string cameras =
      fmt::format("# Camera list\n# Number of cameras: {}\n", model.cameras.size());
  for (const WrittenCamera& camera : model.cameras)
    cameras += fmt::format("{} {} {} {} {}\n", camera.id, camera.model, camera.width, camera.height,
                           fmt::join(camera.parameters, " "));
  std::string images =
      fmt::format("# Number of images: {}, mean observations per image: 1\n", model.images.size());
  for (const WrittenImage& image : model.images) {
    const glm::dvec3& t = image.translation;
    images += fmt::format("7 {} {} {} {} {} {}\n", fmt::join(image.quaternion, " "), t.x, t.y, t.z,
                          image.camera, image.name);
    for (int i = 0; i < image.features; ++i) images += fmt::format("{} 2.5 -1 ", 1.5 * i);
    images += "\n";
  }
  std::string points =
      fmt::format("# Number of points: {}, mean track length: 2\n", model.points.size());
  for (const auto& [p, c] : model.points)
    points += fmt::format("9 {} {} {} {} {} {} 0.5 0 1 2 3\n", p.x, p.y, p.z, c[0], c[1], c[2]);
  write_bytes(folder / "cameras.txt", cameras);
  write_bytes(folder / "images.txt", images);
  write_bytes(folder / "points3D.txt", points);
}

void write_photo_set(const std::filesystem::path& capture, const WrittenModel& model) {
  write_colmap_bin(capture / "sparse/0", model);
  const WrittenCamera& camera = model.cameras.front();
  for (size_t i = 0; i < model.images.size(); ++i) {
    const auto path = capture / "images" / model.images[i].name;
    std::filesystem::create_directories(path.parent_path());
    write_png(path, patterned_image(int(camera.width), int(camera.height), 3, int(i)));
  }
}

}  // namespace tessera::testing
