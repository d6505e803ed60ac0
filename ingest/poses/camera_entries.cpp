// Tells the forms apart by their keys; values are not looked at.
#include "ingest/poses/camera_entries.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;
using std::filesystem::path;

std::string name_of(const json& entry, const std::string& where) {
  if (const std::string name = string_at(entry, "name", where); !name.empty()) return name;
  if (const auto ours = entry.find("tessera"); ours != entry.end() && ours->is_object())
    return string_at(*ours, "camera", where);
  return path(string_at(entry, "file_path", where))
      .lexically_normal()
      .replace_extension()
      .generic_string();
}

std::vector<CameraEntry> listed(const json& list, const std::string& file_where) {
  std::vector<CameraEntry> entries;
  for (const auto& [key, value] : list.items()) {
    const std::string where = fmt::format("{}, camera {}", file_where, key);
    if (!value.is_object())
      throw InputError(fmt::format("{}: is no object; expected a camera's pose", where));
    const std::string name = list.is_object() ? key : name_of(value, where);
    entries.push_back(
        {name, list.is_object() ? where : fmt::format("{} ({})", where, name), value});
  }
  return entries;
}

/// Keys of one camera, with an underscore and its name behind them, by the key that it gets here.
constexpr std::array<std::pair<const char*, const char*>, 8> kNamedKeys{{{"K_", "K"},
                                                                         {"D_", "D"},
                                                                         {"dist_", "D"},
                                                                         {"R_", "R"},
                                                                         {"Rot_", "R"},
                                                                         {"T_", "T"},
                                                                         {"W_", "w"},
                                                                         {"H_", "h"}}};

/// In the order of their names. Rot_NAME stands before R_NAME, which is the same as a vector.
std::vector<CameraEntry> by_suffix(const json& file, const std::string& file_where) {
  std::map<std::string, json> cameras;
  for (const auto& [prefix, key] : kNamedKeys)
    for (const auto& [stated, value] : file.items())
      if (stated.starts_with(prefix))
        cameras[stated.substr(std::string(prefix).size())][key] = value;
  std::vector<CameraEntry> entries;
  for (auto& [name, values] : cameras)
    entries.push_back({name, fmt::format("{}, camera {}", file_where, name), std::move(values)});
  return entries;
}

bool has_key_with(const json& file, const char* prefix) {
  return std::any_of(file.items().begin(), file.items().end(),
                     [&](const auto& item) { return item.key().starts_with(prefix); });
}

/// Whether the object itself states a camera.
bool is_camera(const json& object) {
  constexpr std::array kKeys{"K",
                             "camera_matrix",
                             "cameraMatrix",
                             "CameraMatrix",
                             "mtx",
                             "R",
                             "rvec",
                             "Rvec",
                             "tvec",
                             "R_w2c",
                             "R_c2w",
                             "transform_matrix",
                             "w2c",
                             "c2w",
                             "distortion_coefficients"};
  return object.is_object() && std::any_of(kKeys.begin(), kKeys.end(),
                                           [&](const char* key) { return object.contains(key); });
}

}  // namespace

std::vector<CameraEntry> camera_entries(const json& file, const path& path) {
  const std::string where = path.string();
  std::vector<CameraEntry> entries;
  if (file.is_array()) {
    entries = listed(file, where);
  } else if (file.is_object()) {
    const auto is_group = [&](const char* key) {
      return file.contains(key) && (file[key].is_array() || file[key].is_object());
    };
    for (const char* key : {"cameras", "frames"})
      if (entries.empty() && is_group(key)) entries = listed(file[key], where);
    if (!entries.empty()) return entries;
    const bool has_suffixes = has_key_with(file, "K_") || has_key_with(file, "Rot_");
    if (has_suffixes) return by_suffix(file, where);
    if (is_camera(file)) {
      std::string name = string_at(file, "name", where);
      if (name.empty()) name = path.stem().string();
      return {{name, fmt::format("{}, camera {}", where, name), file}};
    }
    if (std::any_of(file.begin(), file.end(), is_camera)) entries = listed(file, where);
  }
  if (entries.empty())
    throw InputError(fmt::format(
        "{}: has no list 'cameras' or 'frames' and no camera (K, R, T); expected one entry a "
        "camera with its pose",
        where));
  return entries;
}

}  // namespace tessera
