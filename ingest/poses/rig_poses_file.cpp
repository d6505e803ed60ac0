// Parses the formats of `--poses FILE` and matches the names.
#include "ingest/poses/rig_poses_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/poses/llff_poses.h"
#include "ingest/poses/transforms_values.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;
using std::filesystem::path;

std::vector<RigCamera> read_llff_rows(const path& file, const std::vector<std::string>& names) {
  const auto rows = read_llff_poses(file);
  if (rows.size() != names.size())
    throw InputError(fmt::format(
        "{}: has {} rows, there are {} cameras ({}); LLFF has one row a camera in the order of "
        "their names",
        file.string(), rows.size(), names.size(), listed_names(names)));
  std::vector<RigCamera> cameras;
  for (size_t i = 0; i < rows.size(); ++i)
    cameras.push_back({names[i], rows[i].camera, {}, "PINHOLE"});
  return cameras;
}

/// `rows` × `columns` finite numbers, row by row. Errors: InputError naming `key`.
std::vector<double> numbers(const json& value, size_t rows, size_t columns, const char* key,
                            const std::string& where) {
  std::vector<double> all;
  if (value.is_array() && value.size() == rows)
    for (const json& row : value) {
      const json cells = row.is_array() ? row : json::array({row});
      if (cells.size() != columns) break;
      for (const json& cell : cells)
        if (cell.is_number() && std::isfinite(cell.get<double>())) all.push_back(cell);
    }
  if (all.size() != rows * columns)
    throw InputError(fmt::format("{}: {} is not {} finite numbers; correct this camera", where, key,
                                 rows * columns));
  return all;
}

/// x_cam = R x + t in OpenCV axes as OpenGL's camera-to-world, whose checks it then passes.
PoseRows gl_rows_of_opencv(const json& entry, const std::string& where) {
  const auto r = numbers(entry["R_w2c"], 3, 3, "R_w2c", where);
  const auto t = numbers(entry.contains("t_w2c") ? entry["t_w2c"] : json(), 3, 1, "t_w2c", where);
  PoseRows rows{};
  for (size_t axis = 0; axis < 3; ++axis) {
    double centre = 0;
    for (size_t k = 0; k < 3; ++k) centre -= r[3 * k + axis] * t[k];
    rows[axis] = {r[axis], -r[3 + axis], -r[6 + axis], centre};
  }
  return rows;
}

std::string name_of(const json& entry, const std::string& where) {
  if (const std::string name = string_at(entry, "name", where); !name.empty()) return name;
  if (const auto ours = entry.find("tessera"); ours != entry.end() && ours->is_object())
    return string_at(*ours, "camera", where);
  return path(string_at(entry, "file_path", where)).stem().string();
}

StatedIntrinsics intrinsics_at(const json& object, const std::string& where) {
  StatedIntrinsics stated = intrinsics_of(object, where);
  if (!stated.fl_x) stated.fl_x = finite_number(object, "fx", where);
  if (!stated.fl_y) stated.fl_y = finite_number(object, "fy", where);
  return stated;
}

RigCamera parse_camera(const json& entry, const json& file, const std::string& file_where,
                       size_t index) {
  std::string where = fmt::format("{}, camera {}", file_where, index);
  if (!entry.is_object())
    throw InputError(fmt::format("{}: is no object; expected a camera's pose", where));
  RigCamera camera;
  camera.name = name_of(entry, where);
  where += fmt::format(" ({})", camera.name);
  const json shared =
      file.contains("intrinsics") && file["intrinsics"].is_object() ? file["intrinsics"] : file;
  const StatedIntrinsics stated =
      intrinsics_at(entry, where).or_else(intrinsics_at(shared, file_where));
  if (!stated.w || !stated.h)
    throw InputError(
        fmt::format("{}: no image size; add w and h, which its intrinsics belong to", where));
  set_intrinsics(camera.camera, stated, *stated.w, *stated.h, where);
  set_pose(camera.camera,
           entry.contains("R_w2c") ? gl_rows_of_opencv(entry, where) : pose_rows(entry, where),
           where);
  const StatedLens lens = stated_lens(entry, shared, where);
  camera.lens = lens.lens;
  camera.lens_model = lens.model;
  return camera;
}

std::map<std::string, RigCamera> read_json_cameras(const path& path) {
  const std::string where = path.string();
  const json file = read_json(path);
  const char* key = file.is_object() && file.contains("cameras") ? "cameras" : "frames";
  if (!file.is_object() || !file.contains(key) || !file[key].is_array() || file[key].empty())
    throw InputError(fmt::format(
        "{}: has no list 'cameras' or 'frames'; expected one entry a camera with its pose", where));
  std::map<std::string, RigCamera> cameras;
  for (size_t i = 0; i < file[key].size(); ++i) {
    RigCamera camera = parse_camera(file[key][i], file, where, i);
    const auto [known, is_new] = cameras.emplace(camera.name, camera);
    if (!is_new && !equal_pose(known->second.camera, camera.camera))
      throw InputError(fmt::format(
          "{}: lists camera '{}' with different poses; a rig's camera has one: remove the others",
          where, camera.name));
  }
  return cameras;
}

}  // namespace

std::vector<std::optional<RigCamera>> find_rig_cameras(const path& file,
                                                       const std::vector<std::string>& names,
                                                       std::string& missing) {
  missing.clear();
  std::vector<std::optional<RigCamera>> cameras;
  if (file.extension() == ".npy") {
    for (RigCamera& camera : read_llff_rows(file, names)) cameras.emplace_back(std::move(camera));
    return cameras;
  }
  const auto known = read_json_cameras(file);
  std::vector<std::string> without, listed;
  for (const auto& [name, camera] : known) listed.push_back(name);
  for (const std::string& name : names) {
    const auto found = known.find(name);
    if (found == known.end()) without.push_back(name);
    cameras.push_back(found == known.end() ? std::nullopt : std::optional(found->second));
  }
  if (!without.empty())
    missing = fmt::format("{}: has no camera for {}; it has {}", file.string(),
                          listed_names(without), listed_names(listed));
  return cameras;
}

std::vector<RigCamera> read_rig_cameras(const path& file, const std::vector<std::string>& names) {
  std::string missing;
  const auto found = find_rig_cameras(file, names, missing);
  if (!missing.empty()) throw InputError(fmt::format("{}: {}", missing, kUnposedRemedy));
  std::vector<RigCamera> cameras;
  for (const std::optional<RigCamera>& camera : found) cameras.push_back(*camera);
  return cameras;
}

Camera camera_of_image(const Camera& stated, int width, int height, const std::string& where) {
  if (same_shape(stated.width, stated.height, width, height)) return stated.resized(width, height);
  constexpr int kBlock = 16;  // pixels a side, of H.264; others' blocks are multiples of 8
  const int less_x = stated.width - width, less_y = stated.height - height;
  const bool cut = less_x >= 0 && less_y >= 0 && less_x < kBlock && less_y < kBlock &&
                   (less_x == 0 || less_y == 0);
  if (!cut)
    throw InputError(fmt::format(
        "{}: the image is {}x{}, its camera was calibrated at {}x{}; use images of that shape, "
        "or correct the camera",
        where, width, height, stated.width, stated.height));
  Camera camera = stated;
  camera.width = width;
  camera.height = height;
  return camera;
}

}  // namespace tessera
