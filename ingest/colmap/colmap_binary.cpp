// Reads cameras.bin, images.bin and points3D.bin (COLMAP 3.8): little-endian records without
// padding. Each count is checked against the remaining bytes before memory is allocated.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "ingest/colmap/colmap_records.h"
#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Reads values in order; running out of bytes is an error that names the record.
class BinaryCursor {
 public:
  BinaryCursor(const std::filesystem::path& path, const char* what)
      : name_(path.string()), what_(what), bytes_(read_text_file(path)) {}

  template <class T>
  T take() {
    need(sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string take_name() {
    const size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) fail("is truncated within a name");
    const std::string name = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return name;
  }
  /// The number of records, each of at least `least` bytes.
  uint64_t take_count(uint64_t least) {
    const auto count = take<uint64_t>();
    if (count > (bytes_.size() - at_) / least)
      fail(fmt::format("is truncated: it states {} {}, of which its {} bytes hold at most {}",
                       count, what_, bytes_.size(), (bytes_.size() - at_) / least));
    records_ = count;
    return count;
  }
  /// The length of a list whose entries have `size` bytes.
  uint64_t take_length(uint64_t size) {
    const auto count = take<uint64_t>();
    if (count > (bytes_.size() - at_) / size)
      fail(
          fmt::format("is truncated or damaged: a list of {} entries of {} bytes begins {} bytes "
                      "before the end",
                      count, size, bytes_.size() - at_));
    return count;
  }
  /// Passes over a list: its length, then its entries.
  void skip_list(uint64_t size) { at_ += take_length(size) * size; }
  void begin_record() { ++record_; }
  std::string where() const { return fmt::format("{}, {} {}", name_, what_, record_); }
  void expect_end() const {
    if (at_ != bytes_.size())
      throw InputError(fmt::format(
          "{}: has {} bytes after its {} {}, expected none; copy the model again, or write it "
          "again with `colmap model_converter`",
          name_, bytes_.size() - at_, records_, what_));
  }
  [[noreturn]] void fail(const std::string& seen) const {
    throw InputError(
        fmt::format("{} {} (at byte {}, record {} of {}); copy the model again, or write it again "
                    "with `colmap model_converter`",
                    name_, seen, at_, record_, records_));
  }

 private:
  void need(size_t count) const {
    if (count > bytes_.size() - at_)
      fail(fmt::format("is truncated: it ends after {} bytes", bytes_.size()));
  }

  std::string name_;
  const char* what_;  // of a record, in the plural
  std::string bytes_;
  size_t at_ = 0;
  uint64_t record_ = 0, records_ = 0;
};

}  // namespace

ColmapCameras read_colmap_cameras_bin(const std::filesystem::path& path) {
  constexpr uint64_t kLeastBytes = 4 + 4 + 8 + 8 + 3 * 8;
  BinaryCursor file(path, "cameras");
  ColmapCameras cameras;
  for (uint64_t left = file.take_count(kLeastBytes); left > 0; --left) {
    file.begin_record();
    const auto id = file.take<uint32_t>();
    const std::string where = file.where();
    const ColmapCameraModel& model = colmap_camera_model(file.take<int32_t>(), where);
    const auto width = file.take<uint64_t>();
    const auto height = file.take<uint64_t>();
    std::vector<double> parameters(model.parameter_count());
    for (double& parameter : parameters) parameter = file.take<double>();
    const ColmapCamera camera = camera_or_reason(
        [&] { return make_colmap_camera(model, width, height, parameters, file.where()); });
    if (!cameras.emplace(id, camera).second) file.fail(fmt::format("lists camera {} twice", id));
  }
  file.expect_end();
  return cameras;
}

std::vector<ColmapImage> read_colmap_images_bin(const std::filesystem::path& path) {
  constexpr uint64_t kLeastBytes = 4 + 7 * 8 + 4 + 1 + 8, kFeatureBytes = 2 * 8 + 8;
  BinaryCursor file(path, "images");
  std::vector<ColmapImage> images;
  for (uint64_t left = file.take_count(kLeastBytes); left > 0; --left) {
    file.begin_record();
    ColmapImage image;
    image.id = file.take<uint32_t>();
    for (double& value : image.quaternion) value = file.take<double>();
    for (glm::length_t i = 0; i < 3; ++i) image.translation[i] = file.take<double>();
    image.camera = file.take<uint32_t>();
    image.name = file.take_name();
    file.skip_list(kFeatureBytes);
    images.push_back(std::move(image));
  }
  file.expect_end();
  return images;
}

ColmapPoints read_colmap_points_bin(const std::filesystem::path& path, const glm::dvec3& origin) {
  constexpr uint64_t kLeastBytes = 8 + 3 * 8 + 3 + 8 + 8, kTrackBytes = 4 + 4;
  BinaryCursor file(path, "points");
  PointCloud points;
  double errors = 0;
  ImageErrors by_image;
  std::vector<uint64_t> ids;
  for (uint64_t left = file.take_count(kLeastBytes); left > 0; --left) {
    file.begin_record();
    ids.push_back(file.take<uint64_t>());
    glm::dvec3 position;
    for (glm::length_t i = 0; i < 3; ++i) position[i] = file.take<double>();
    std::array<uint8_t, 3> colour;
    for (uint8_t& value : colour) value = file.take<uint8_t>();
    const auto error = file.take<double>();
    errors += error;
    for (uint64_t seen = file.take_length(kTrackBytes); seen > 0; --seen) {
      by_image[file.take<uint32_t>()].add(error);
      file.take<uint32_t>();  // the feature
    }
    points.position.emplace_back(position - origin);
    points.colour.push_back(colour);
  }
  file.expect_end();
  sort_by_id(points, ids);
  const double count = double(std::max<size_t>(1, ids.size()));
  return {std::move(points), errors / count, std::move(by_image)};
}

}  // namespace tessera
