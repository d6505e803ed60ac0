// Reads cameras.txt, images.txt and points3D.txt: values are separated by blanks, and # begins a
// comment. COLMAP writes a line of observations behind each image, which may be empty; other
// programs and editors leave the last one or all of them out.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "ingest/colmap/colmap_records.h"
#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

template <class T>
std::optional<T> number_of(std::string_view word) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// One line, word by word.
class Words {
 public:
  Words(std::string_view line, std::string where) : rest_(line), where_(std::move(where)) {}

  std::string_view next() {
    trim();
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_.remove_prefix(word.size());
    return word;
  }
  template <class T>
  T number(const char* what) {
    const std::string_view word = next();
    if (word.empty()) fail(fmt::format("ends before {}", what));
    const std::optional<T> value = number_of<T>(word);
    if (!value) fail(fmt::format("has '{}' for {}, expected a number", word, what));
    return *value;
  }
  /// All that is left, without blanks around it.
  std::string_view rest() {
    trim();
    return rest_.substr(0, rest_.find_last_not_of(" \t") + 1);
  }
  int64_t count_left() {
    int64_t count = 0;
    while (!next().empty()) ++count;
    return count;
  }
  const std::string& where() const { return where_; }
  [[noreturn]] void fail(const std::string& seen) const {
    throw InputError(fmt::format(
        "{}: {}; the file is truncated or damaged: copy the model again, or write it again with "
        "`colmap model_converter`",
        where_, seen));
  }

 private:
  void trim() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size())); }

  std::string_view rest_;
  std::string where_;
};

/// An id, a pose, a camera's id and a name, which is not all numbers as observations are.
bool is_image(std::string_view line) {
  Words words(line, "");
  if (!number_of<uint32_t>(words.next())) return false;
  for (int i = 0; i < 7; ++i)
    if (!number_of<double>(words.next())) return false;
  if (!number_of<uint32_t>(words.next())) return false;
  for (std::string_view word = words.next(); !word.empty(); word = words.next())
    if (!number_of<double>(word)) return true;
  return false;
}

/// The lines of a file, and the count that its comment states.
class TextRecords {
 public:
  explicit TextRecords(const std::filesystem::path& path)
      : name_(path.string()), text_(read_plain_text(path)) {}

  /// The next line that holds a record.
  std::optional<Words> next_record() {
    while (auto line = next_line()) {
      if (line->starts_with('#')) note_count(*line);
      if (line->starts_with('#') || line->find_first_not_of(" \t") == std::string_view::npos)
        continue;
      ++records_;
      return Words(*line, where());
    }
    return std::nullopt;
  }
  /// The line after an image, unless it is the next image, a comment or the end of the file.
  std::optional<Words> observations() {
    const size_t before = at_;
    const auto line = next_line();
    if (!line) return std::nullopt;
    if (!line->starts_with('#') && !is_image(*line)) return Words(*line, where());
    at_ = before;
    --line_;
    return std::nullopt;
  }
  /// A stated count that is not the one found.
  void check_count(std::vector<std::string>& warnings) const {
    if (stated_ && *stated_ != records_)
      warnings.push_back(
          fmt::format("{}: states {} records in its comment, holds {}", name_, *stated_, records_));
  }

 private:
  std::string where() const { return fmt::format("{}, line {}", name_, line_); }
  std::optional<std::string_view> next_line() {
    if (at_ >= text_.size()) return std::nullopt;
    std::string_view line = std::string_view(text_).substr(at_);
    line = line.substr(0, line.find('\n'));
    at_ += line.size() + 1;
    ++line_;
    return line;
  }
  void note_count(std::string_view comment) {
    const size_t colon = comment.find(':');
    if (!comment.starts_with("# Number of ") || colon == std::string_view::npos) return;
    comment.remove_prefix(std::min(comment.find_first_not_of(' ', colon + 1), comment.size()));
    int64_t count = 0;
    if (std::from_chars(comment.data(), comment.data() + comment.size(), count).ec == std::errc{})
      stated_ = count;
  }

  std::string name_, text_;
  size_t at_ = 0;
  int64_t line_ = 0, records_ = 0;
  std::optional<int64_t> stated_;
};

}  // namespace

ColmapCameras read_colmap_cameras_txt(const std::filesystem::path& path,
                                      std::vector<std::string>& warnings) {
  TextRecords file(path);
  ColmapCameras cameras;
  while (auto words = file.next_record()) {
    const auto id = words->number<uint32_t>("the camera's id");
    const ColmapCamera camera = camera_or_reason([&] {
      const std::string name(words->next());
      const ColmapCameraModel& model = colmap_camera_model(name, words->where());
      const auto width = words->number<uint64_t>("the width");
      const auto height = words->number<uint64_t>("the height");
      std::vector<double> parameters;
      while (!words->rest().empty()) parameters.push_back(words->number<double>("a parameter"));
      return make_colmap_camera(model, width, height, parameters, words->where());
    });
    if (!cameras.emplace(id, camera).second) words->fail(fmt::format("lists camera {} twice", id));
  }
  file.check_count(warnings);
  return cameras;
}

std::vector<ColmapImage> read_colmap_images_txt(const std::filesystem::path& path,
                                                std::vector<std::string>& warnings) {
  TextRecords file(path);
  std::vector<ColmapImage> images;
  while (auto words = file.next_record()) {
    ColmapImage image;
    words->number<uint32_t>("the image's id");
    for (double& value : image.quaternion) value = words->number<double>("the quaternion");
    for (glm::length_t i = 0; i < 3; ++i)
      image.translation[i] = words->number<double>("the translation");
    image.camera = words->number<uint32_t>("the camera's id");
    image.name = words->rest();
    if (image.name.empty()) words->fail("ends before the image's name");
    if (std::optional<Words> features = file.observations())
      if (const int64_t count = features->count_left(); count % 3 != 0)
        features->fail(
            fmt::format("has {} values, expected x, y and a point's id of each feature", count));
    images.push_back(std::move(image));
  }
  file.check_count(warnings);
  return images;
}

ColmapPoints read_colmap_points_txt(const std::filesystem::path& path, const glm::dvec3& origin,
                                    std::vector<std::string>& warnings) {
  TextRecords file(path);
  PointCloud points;
  double errors = 0;
  std::vector<uint64_t> ids;
  while (auto words = file.next_record()) {
    ids.push_back(words->number<uint64_t>("the point's id"));
    glm::dvec3 position;
    for (glm::length_t i = 0; i < 3; ++i) position[i] = words->number<double>("the position");
    std::array<uint8_t, 3> colour;
    for (uint8_t& value : colour) value = words->number<uint8_t>("the colour (0 to 255)");
    errors += words->number<double>("the error");
    if (words->count_left() % 2 != 0) words->fail("has a track of an odd number of values");
    points.position.emplace_back(position - origin);
    points.colour.push_back(colour);
  }
  file.check_count(warnings);
  sort_by_id(points, ids);
  const double count = double(std::max<size_t>(1, ids.size()));
  return {std::move(points), errors / count};
}

}  // namespace tessera
