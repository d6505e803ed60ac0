// Chooses the reader by names of files and by what lies in a folder.
#include "ingest/calibration/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "ingest/colmap/colmap_model.h"
#include "ingest/files/json_file.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/poses/opencv_file.h"
#include "ingest/poses/rig_poses_file.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string extension_of(const fs::path& file) {
  return lower_case(file.extension().string());
}

bool is_opencv_name(const fs::path& file) {
  const std::string extension = extension_of(file);
  return extension == ".yml" || extension == ".yaml" || extension == ".xml";
}

Calibration of_model(const fs::path& folder) {
  ColmapModel model = read_colmap_model(folder);
  Calibration calibration{.path = folder,
                          .form = "COLMAP model",
                          .points = std::move(model.points),
                          .files = std::move(model.files),
                          .warnings = std::move(model.warnings),
                          .origin = model.origin};
  for (ColmapPhoto& photo : model.photos)
    calibration.cameras.push_back(
        {std::move(photo.name), photo.camera, photo.lens, std::move(photo.lens_model)});
  return calibration;
}

Calibration of_rows(const fs::path& file) {
  Calibration calibration{.path = file, .form = "LLFF poses", .by_row = true, .files = {file}};
  for (const LlffPose& pose : read_llff_poses(file))
    calibration.cameras.push_back(
        {fmt::format("row {}", calibration.cameras.size()), pose.camera, {}, "PINHOLE"});
  if (calibration.cameras.empty())
    throw InputError(fmt::format("{}: has no rows; expected one a camera", file.string()));
  return calibration;
}

json tree_of_file(const fs::path& file) {
  return is_opencv_name(file) ? read_opencv_tree(file) : read_json(file);
}

/// Both files as one tree: their keys have different first letters.
Calibration of_easymocap(const EasyMocapFiles& pair) {
  json tree = read_opencv_tree(pair.intri);
  const json poses = read_opencv_tree(pair.extri);
  if (!tree.is_object() || !poses.is_object())
    throw InputError(fmt::format("{}: has no keys K_NAME and, in {}, Rot_NAME and T_NAME",
                                 pair.intri.string(), pair.extri.filename().string()));
  tree.update(poses);
  const fs::path folder = pair.intri.parent_path();
  Calibration calibration{
      .path = folder, .form = "intri and extri of EasyMocap", .files = {pair.intri, pair.extri}};
  calibration.cameras = rig_cameras_of(tree, folder, calibration.notes);
  return calibration;
}

Calibration of_file(const fs::path& file) {
  Calibration calibration{.path = file,
                          .form = extension_of(file) == ".json" ? "JSON" : "OpenCV file",
                          .files = {file}};
  calibration.cameras = rig_cameras_of(tree_of_file(file), file, calibration.notes);
  return calibration;
}

/// One camera a file, called as the file. An empty calibration where there is no such file.
Calibration of_camera_files(const fs::path& folder) {
  Calibration all{.path = folder, .form = "files of cameras"};
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::error_code unreachable;
    const bool is_ours = is_opencv_name(entry.path()) || extension_of(entry.path()) == ".json";
    if (is_ours && entry.is_regular_file(unreachable) &&
        !entry.path().filename().string().starts_with('.'))
      all.files.push_back(entry.path());
  }
  std::sort(all.files.begin(), all.files.end());
  for (const fs::path& file : all.files)
    for (RigCamera& camera : rig_cameras_of(tree_of_file(file), file, all.notes)) {
      const bool is_known =
          std::any_of(all.cameras.begin(), all.cameras.end(),
                      [&](const RigCamera& other) { return other.name == camera.name; });
      if (is_known)
        throw InputError(fmt::format(
            "{}: states camera '{}' as another file of this folder does; name the file to be used",
            file.string(), camera.name));
      all.cameras.push_back(std::move(camera));
    }
  return all;
}

[[noreturn]] void refuse_form(const fs::path& path, const std::string& seen) {
  throw InputError(
      fmt::format("{}: {}; poses are read from {}", path.string(), seen, kCalibrationForms));
}

Calibration of_folder(const fs::path& folder) {
  if (const auto models = colmap_models_in(folder); !models.empty())
    return of_model(models.front());
  if (const EasyMocapFiles pair = find_easymocap(folder); !pair.intri.empty())
    return of_easymocap(pair);
  if (const fs::path rows = folder / "poses_bounds.npy"; fs::exists(rows)) return of_rows(rows);
  if (const fs::path file = folder / "transforms.json"; fs::exists(file)) return of_file(file);
  Calibration calibration = of_camera_files(folder);
  if (calibration.cameras.empty()) refuse_form(folder, "holds no calibration");
  return calibration;
}

/// Whether the file is one of those that a COLMAP model consists of.
bool is_file_of_model(const fs::path& file) {
  constexpr std::array kNames{"cameras", "images", "points3d", "frames", "rigs"};
  const std::string stem = lower_case(file.stem().string()), extension = extension_of(file);
  return (extension == ".bin" || extension == ".txt") &&
         std::find(kNames.begin(), kNames.end(), stem) != kNames.end();
}

}  // namespace

EasyMocapFiles find_easymocap(const fs::path& folder) {
  for (const char* extension : {".yml", ".yaml"}) {
    EasyMocapFiles pair{folder / ("intri" + std::string(extension)),
                        folder / ("extri" + std::string(extension))};
    if (fs::is_regular_file(pair.intri) && fs::is_regular_file(pair.extri)) return pair;
  }
  return {};
}

Calibration read_calibration(const fs::path& path) {
  std::error_code unreachable;
  if (fs::is_directory(path, unreachable)) return of_folder(path);
  if (!fs::exists(path, unreachable)) refuse_form(path, "no such file or folder");
  if (is_file_of_model(path)) return of_model(path.parent_path());
  if (extension_of(path) == ".npy") return of_rows(path);
  const std::string stem = lower_case(path.stem().string());
  if (is_opencv_name(path) && (stem == "intri" || stem == "extri")) {
    const EasyMocapFiles pair = find_easymocap(path.parent_path());
    if (pair.intri.empty())
      refuse_form(path, "intri.yml and extri.yml belong together, and one of them is missing");
    return of_easymocap(pair);
  }
  if (is_opencv_name(path) || extension_of(path) == ".json") return of_file(path);
  refuse_form(path, "is of no form that is read");
}

}  // namespace tessera
