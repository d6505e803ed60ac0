// Tells the forms apart by their keys; values are not looked at.
#include "ingest/poses/camera_entries.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "ingest/files/json_file.h"
#include "ingest/poses/stated_object.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"

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

/// What stands before the names of cameras in keys, by the key that it gets here.
std::string key_of_prefix(const std::string& prefix) {
  if (prefix == "Rot") return "R";
  return prefix == "W" || prefix == "H" ? lower_case(prefix) : prefix;
}

bool begins_a_camera(const std::string& key) {
  return key.starts_with("K_") || key.starts_with("Rot_");
}

/// In the order of their names. Rot_NAME stands for R_NAME, which is the same as a vector.
std::vector<CameraEntry> by_suffix(const json& file, const std::string& file_where) {
  std::map<std::string, json> cameras;
  for (const auto& [key, value] : file.items())
    if (begins_a_camera(key)) cameras[key.substr(key.find('_') + 1)] = json::object();
  for (const auto& [key, value] : file.items())
    for (size_t end = key.find('_'); end != std::string::npos; end = key.find('_', end + 1))
      if (const auto camera = cameras.find(key.substr(end + 1)); camera != cameras.end()) {
        if (key.substr(0, end) != "R" || !file.contains("Rot_" + camera->first))
          camera->second[key_of_prefix(key.substr(0, end))] = value;
        break;
      }
  std::vector<CameraEntry> entries;
  for (auto& [name, values] : cameras)
    entries.push_back({name, fmt::format("{}, camera {}", file_where, name), std::move(values)});
  return entries;
}

/// Whether the object itself states a camera.
bool is_camera(const json& object) {
  constexpr std::array<std::string_view, 16> kKeys{"k",
                                                   "cameramatrix",
                                                   "mtx",
                                                   "r",
                                                   "rot",
                                                   "rvec",
                                                   "tvec",
                                                   "rotation",
                                                   "rw2c",
                                                   "rc2w",
                                                   "transformmatrix",
                                                   "w2c",
                                                   "c2w",
                                                   "rt",
                                                   "extrinsics",
                                                   "distortioncoefficients"};
  if (!object.is_object()) return false;
  return std::any_of(object.items().begin(), object.items().end(), [&](const auto& item) {
    const bool is_matrix = item.value().is_array() || item.value().contains("data");
    return is_matrix && std::find(kKeys.begin(), kKeys.end(), plain_key(item.key())) != kKeys.end();
  });
}

/// The members of `file` but that one, with those of its object `intrinsics`.
json shared_of(json file, const char* group) {
  file.erase(group);
  if (const auto found = file.find("intrinsics"); found != file.end() && found->is_object()) {
    const json intrinsics = std::move(*found);
    file.erase("intrinsics");
    file.update(intrinsics);
  }
  return file;
}

CameraEntries entries_of(const json& file, const path& path) {
  const std::string where = path.string();
  if (file.is_array()) return {listed(file, where), {}};
  if (!file.is_object()) return {};
  for (const char* key : {"cameras", "frames"})
    if (const auto group = file.find(key);
        group != file.end() && (group->is_array() || group->is_object()) && !group->empty())
      return {listed(*group, where), shared_of(file, key)};
  if (std::any_of(file.items().begin(), file.items().end(),
                  [](const auto& item) { return begins_a_camera(item.key()); }))
    return {by_suffix(file, where), {}};
  if (is_camera(file)) {
    std::string name = string_at(file, "name", where);
    if (name.empty()) name = path.stem().string();
    return {{{name, fmt::format("{}, camera {}", where, name), file}}, {}};
  }
  if (std::any_of(file.begin(), file.end(), is_camera)) return {listed(file, where), {}};
  return {};
}

}  // namespace

CameraEntries camera_entries(const json& file, const path& path) {
  CameraEntries found = entries_of(file, path);
  if (found.entries.empty())
    throw InputError(fmt::format(
        "{}: has no list 'cameras' or 'frames' and no camera (K, R, T); expected one entry a "
        "camera with its pose",
        path.string()));
  return found;
}

}  // namespace tessera
