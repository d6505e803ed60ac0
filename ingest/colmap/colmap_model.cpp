// Chooses the files of a model and checks their consistency.
#include "ingest/colmap/colmap_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <numeric>
#include <string_view>
#include <tuple>

#include "ingest/colmap/colmap_records.h"
#include "ingest/files/folders.h"
#include "ingest/images/image_paths.h"
#include "ingest/poses/far_origin.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// x_cam = R(q)·x_world + t, +x right, +y down, +z forward: Camera's own convention.
void put_pose(Camera& camera, const ColmapImage& image, const std::string& where) {
  const auto& [w, x, y, z] = image.quaternion;
  const glm::dquat rotation(w, x, y, z);
  const double length = std::sqrt(w * w + x * x + y * y + z * z);
  const glm::dvec3& t = image.translation;
  if (!std::isfinite(length) || length < 1e-9 || !std::isfinite(t.x + t.y + t.z))
    throw InputError(
        fmt::format("{}: the pose of {} has a quaternion of length {} and a translation of ({}, "
                    "{}, {}), expected a rotation and finite numbers; write the model again, or "
                    "remove this image",
                    where, image.name, length, t.x, t.y, t.z));
  camera.cam_from_world = glm::mat3_cast(rotation / length);
  camera.translation = t;
}

/// "cameras.txt" or "Cameras.txt", as other programs write it; empty where there is none.
std::filesystem::path file_of_model(const std::filesystem::path& folder, const std::string& name) {
  return find_entry(folder, name, std::filesystem::file_type::regular);
}

/// ".bin" or ".txt"; empty where the folder has no list of cameras.
std::string model_kind(const std::filesystem::path& folder) {
  for (const char* extension : {".bin", ".txt"})
    if (!file_of_model(folder, std::string("cameras") + extension).empty()) return extension;
  return "";
}

struct FoundModel {
  std::filesystem::path folder;
  int rank = 0;         // COLMAP's own places come first, what lies beside the images last
  uintmax_t bytes = 0;  // of its list of images: a larger model has more of them
};

/// Whether the folder is a capture of its own, or a camera of one.
bool holds_media(const std::filesystem::path& folder) {
  std::error_code unreachable;
  for (const auto& entry : std::filesystem::directory_iterator(folder, unreachable)) {
    std::error_code unresolved;
    const bool is_folder = entry.is_directory(unresolved);
    if (is_folder ? entry.path().filename() == "images" : is_image_name(entry.path())) return true;
  }
  return false;
}

/// Models in `folder` and so many levels below.
void find_models(const std::filesystem::path& folder, const std::filesystem::path& capture,
                 int levels, std::vector<FoundModel>& found) {
  std::error_code unreachable;
  if (const std::string kind = model_kind(folder); !kind.empty()) {
    const std::filesystem::path place = folder.lexically_relative(capture),
                                images = file_of_model(folder, "images" + kind);
    const int rank = place == "." ? 2 : *place.begin() == "sparse" ? 0 : 1;
    std::error_code absent;
    const uintmax_t bytes = images.empty() ? 0 : std::filesystem::file_size(images, absent);
    if (bytes > 0 || rank == 0) found.push_back({folder, rank, bytes});
  }
  if (levels == 0) return;
  for (const auto& entry : std::filesystem::directory_iterator(folder, unreachable)) {
    std::error_code unresolved;
    if (entry.is_directory(unresolved) && !entry.path().filename().string().starts_with('.') &&
        !holds_media(entry.path()))
      find_models(entry.path(), capture, levels - 1, found);
  }
}

using LeftOut = std::map<std::string, std::vector<std::string>>;  // images by the reason

/// A line a reason. Errors: InputError: no image of `listed` is left.
void report_left_out(const LeftOut& left_out, size_t listed, std::vector<std::string>& warnings) {
  size_t images = 0;
  for (const auto& [reason, names] : left_out) {
    images += names.size();
    warnings.push_back(fmt::format("{}; {} of {} images {} of this camera and left out: {}", reason,
                                   names.size(), listed, names.size() == 1 ? "is" : "are",
                                   listed_names(names)));
  }
  if (images == listed) throw InputError(left_out.begin()->first);
}

std::vector<ColmapPhoto> photos_of(const ColmapCameras& cameras,
                                   const std::vector<ColmapImage>& images, const std::string& where,
                                   std::vector<std::string>& warnings) {
  std::vector<ColmapPhoto> photos;
  LeftOut left_out;
  for (const ColmapImage& image : images) {
    const auto found = cameras.find(image.camera);
    if (found == cameras.end())
      throw InputError(fmt::format(
          "{}: {} is of camera {}, which the cameras file lacks; copy the model's files again, all "
          "from one folder",
          where, image.name, image.camera));
    const ColmapCamera& camera = found->second;
    if (!camera.unusable.empty()) {
      left_out[camera.unusable].push_back(image.name);
      continue;
    }
    photos.push_back({image.name, camera.camera, camera.lens, camera.model});
    put_pose(photos.back().camera, image, where);
  }
  report_left_out(left_out, images.size(), warnings);
  std::sort(photos.begin(), photos.end(),
            [](const ColmapPhoto& a, const ColmapPhoto& b) { return a.name < b.name; });
  const auto twice = std::adjacent_find(
      photos.begin(), photos.end(),
      [](const ColmapPhoto& a, const ColmapPhoto& b) { return a.name == b.name; });
  if (twice != photos.end())
    throw InputError(
        fmt::format("{}: lists the image '{}' twice; write the model again", where, twice->name));
  return photos;
}

void take_origin_out(ColmapModel& model) {
  std::vector<glm::dvec3> centres;
  for (const ColmapPhoto& photo : model.photos) centres.push_back(photo.camera.position());
  model.origin = far_origin(centres);
  for (ColmapPhoto& photo : model.photos)
    photo.camera = camera_in_world(less(model.origin), photo.camera);
}

/// The errors of the points to the photos that see them.
void put_errors(const ImageErrors& errors, const std::vector<ColmapImage>& images,
                std::vector<ColmapPhoto>& photos) {
  if (errors.empty()) return;
  std::map<std::string_view, uint32_t> ids;
  for (const ColmapImage& image : images) ids[image.name] = image.id;
  for (ColmapPhoto& photo : photos)
    if (const auto found = errors.find(ids.at(photo.name)); found != errors.end())
      photo.error = found->second.mean();
}

void drop_infinite_points(PointCloud& points, const std::string& where,
                          std::vector<std::string>& warnings) {
  size_t kept = 0;
  for (size_t i = 0; i < points.position.size(); ++i) {
    const glm::vec3& p = points.position[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) continue;
    points.position[kept] = p;
    points.colour[kept++] = points.colour[i];
  }
  if (kept < points.position.size())
    warnings.push_back(fmt::format("{}: {} of {} points are not finite and were left out", where,
                                   points.position.size() - kept, points.position.size()));
  points.position.resize(kept);
  points.colour.resize(kept);
}

/// Of the models that are found in a capture; one in the capture itself lies beside images.
std::filesystem::path first_of_models(const std::vector<std::filesystem::path>& models,
                                      const std::filesystem::path& capture) {
  for (const std::filesystem::path& folder : models)
    if (folder != capture || !images_in(capture).empty()) return folder;
  return {};
}

}  // namespace

std::vector<std::filesystem::path> colmap_models_in(const std::filesystem::path& capture) {
  std::vector<FoundModel> found;
  find_models(capture, capture, 4, found);
  std::sort(found.begin(), found.end(), [](const FoundModel& a, const FoundModel& b) {
    return std::tie(a.rank, b.bytes, a.folder) < std::tie(b.rank, a.bytes, b.folder);
  });
  std::vector<std::filesystem::path> folders;
  for (FoundModel& model : found) folders.push_back(std::move(model.folder));
  return folders;
}

std::filesystem::path find_colmap_model(const std::filesystem::path& capture) {
  return first_of_models(colmap_models_in(capture), capture);
}

ColmapModel read_colmap_model(const std::filesystem::path& folder) {
  const bool binary = model_kind(folder) == ".bin";
  const std::string extension = binary ? ".bin" : ".txt";
  const auto file = [&](const char* name) {
    const auto found = file_of_model(folder, name + extension);
    return found.empty() ? folder / (name + extension) : found;
  };
  const auto cameras_file = file("cameras"), images_file = file("images"),
             points_file = file("points3D");
  ColmapModel model;
  model.files = {cameras_file, images_file};
  for (const auto& needed : model.files)
    if (!std::filesystem::is_regular_file(needed))
      throw InputError(fmt::format(
          "{}: no such file, expected a COLMAP model (cameras, images and points3D, .bin or .txt); "
          "copy the model again",
          needed.string()));
  const auto cameras = binary ? read_colmap_cameras_bin(cameras_file)
                              : read_colmap_cameras_txt(cameras_file, model.warnings);
  const auto images = binary ? read_colmap_images_bin(images_file)
                             : read_colmap_images_txt(images_file, model.warnings);
  if (images.empty())
    throw InputError(
        fmt::format("{}: holds no images; run COLMAP again, on photos that overlap more",
                    images_file.string()));
  model.photos = photos_of(cameras, images, images_file.string(), model.warnings);
  take_origin_out(model);
  if (!std::filesystem::exists(points_file)) {
    model.warnings.push_back(
        fmt::format("{}: no such file; there is no initial cloud", points_file.string()));
    return model;
  }
  ColmapPoints points = binary ? read_colmap_points_bin(points_file, model.origin)
                               : read_colmap_points_txt(points_file, model.origin, model.warnings);
  model.points = std::move(points.cloud);
  model.error = points.error;
  put_errors(points.by_image, images, model.photos);
  model.files.push_back(points_file);
  drop_infinite_points(model.points, points_file.string(), model.warnings);
  return model;
}

ColmapModel read_capture_model(const std::filesystem::path& capture) {
  const std::vector<std::filesystem::path> models = colmap_models_in(capture);
  const std::filesystem::path folder = first_of_models(models, capture);
  if (folder.empty())
    throw InputError(fmt::format(
        "{}: no COLMAP model in it; put cameras, images and points3D (.bin or .txt) into sparse/0",
        capture.string()));
  try {
    ColmapModel model = read_colmap_model(folder);
    std::vector<std::string> others;
    for (const std::filesystem::path& other : models)
      if (other != folder) others.push_back(other.lexically_relative(capture).generic_string());
    if (!others.empty())
      model.warnings.push_back(fmt::format("{}: is the largest model of {} images; not read: {}",
                                           folder.string(), model.photos.size(),
                                           listed_names(others)));
    return model;
  } catch (const InputError& error) {
    if (!std::filesystem::exists(capture / "poses_bounds.npy")) throw;
    throw InputError(fmt::format("{}; or pass --poses llff to use the poses_bounds.npy beside it",
                                 error.what()));
  }
}

void sort_by_id(PointCloud& points, const std::vector<uint64_t>& ids) {
  check(ids.size() == points.position.size(), "an id for each point");
  std::vector<size_t> order(ids.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return ids[a] < ids[b]; });
  PointCloud sorted;
  for (const size_t i : order) {
    sorted.position.push_back(points.position[i]);
    sorted.colour.push_back(points.colour[i]);
  }
  points = std::move(sorted);
}

}  // namespace tessera
