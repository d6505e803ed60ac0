// Reads a folder of photos with a COLMAP model, with the poses of LLFF, or without poses, as a
// scene that stands still.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "ingest/calibration/model_photos.h"
#include "ingest/images/image_index.h"
#include "ingest/images/image_paths.h"
#include "ingest/layouts/image_sequences.h"
#include "ingest/layouts/layout_readers.h"
#include "ingest/poses/far_origin.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// The images directly in `images`, by name, each with its row of `poses`, as photos of a
/// model without points. Errors: InputError: as read_llff_poses, or another number of rows than of
/// images.
ColmapModel read_llff_photos(const std::filesystem::path& poses,
                             const std::filesystem::path& images) {
  const auto rows = read_llff_poses(poses);
  const auto files = images_in(images);
  if (rows.size() != files.size())
    throw InputError(fmt::format(
        "{}: has {} rows, {} has {} images; LLFF has one row an image in the order of their "
        "names: put back the missing ones or remove those without a pose",
        poses.string(), rows.size(), images.string(), files.size()));
  ColmapModel model;
  model.files = {poses};
  for (size_t i = 0; i < files.size(); ++i)
    model.photos.push_back({files[i].filename().string(), rows[i].camera, {}, "PINHOLE"});
  return model;
}

/// `images` or the folder that is named; where neither is there, the only one of photo_folders().
std::filesystem::path image_folder(const std::filesystem::path& capture, const std::string& named) {
  const auto stated = capture / (named.empty() ? "images" : named);
  if (std::filesystem::is_directory(stated)) return stated;
  const std::vector<std::filesystem::path> folders = photo_folders(capture);
  if (named.empty() && folders.size() == 1) return folders.front();
  std::vector<std::string> names;
  for (const std::filesystem::path& folder : folders)
    if (folder != capture) names.push_back(folder.filename().string());
  std::sort(names.begin(), names.end());
  throw InputError(fmt::format(
      "{}: no such folder; {}", stated.string(),
      names.empty() ? "put the photos that the poses were made of there"
                    : fmt::format("pass --images with one of {}", listed_names(names))));
}

void count_unregistered(const Capture& capture, bool strict, std::vector<std::string>& warnings) {
  const std::filesystem::path& folder = capture.photos;
  std::set<std::filesystem::path> registered;
  for (const CaptureFrame& frame : capture.frames)
    registered.insert(frame.image.lexically_normal());
  std::vector<std::string> others;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (is_file(entry.path()) && is_image_name(entry.path()) &&
        !entry.path().filename().string().starts_with('.') &&
        !registered.contains(entry.path().lexically_normal()))
      others.push_back(entry.path().lexically_relative(folder).generic_string());
  if (others.empty()) return;
  std::sort(others.begin(), others.end());
  const std::string seen = fmt::format(
      "{}: {} images are not in the COLMAP model (not registered) and were left out: {}",
      folder.string(), others.size(), listed_names(others));
  if (strict) throw InputError(seen + "; run COLMAP again, or leave --strict out");
  warnings.push_back(seen);
}

/// One frame and one view; the camera is named as the photo, without extension where that is
/// unique.
void add_photo(const ColmapPhoto& photo, const std::filesystem::path& file,
               std::set<std::string>& names, Capture& capture) {
  CaptureFrame frame;
  frame.image_name = photo.name;
  frame.image = file;
  frame.view = int64_t(capture.views.size());
  frame.frame.camera = photo.camera;
  capture.views.push_back({{}, photo.lens, photo.lens_model, file.string()});
  std::string name = name_of_image(photo.name);
  if (!file.empty()) {
    if (!names.insert(name).second) names.insert(name = name_of_image(photo.name + ".png"));
    frame.source.name = file.lexically_relative(capture.folder).generic_string();
    capture.cameras.push_back({.name = name});
    note_removed_lens(capture.cameras.back(), {photo.lens_model, photo.lens});
  }
  frame.frame.camera_name = name;
  frame.frame.name = "images/" + name;
  frame.file_path = frame.frame.name + ".png";
  capture.frames.push_back(std::move(frame));
}

Capture photo_set(const std::filesystem::path& folder, const IngestOptions& options,
                  const char* layout) {
  Capture capture;
  capture.folder = folder;
  capture.layout = layout;
  capture.photos = image_folder(folder, options.images);
  return capture;
}

}  // namespace

void take_photos(ColmapModel model, bool strict, Capture& capture) {
  constexpr int64_t kTestEvery = 8;  // the usual protocol for photo sets
  std::vector<std::string>& warnings = capture.warnings;
  warnings.insert(warnings.end(), model.warnings.begin(), model.warnings.end());
  std::vector<std::string> missing;
  std::set<std::string> names;
  ImageIndex images(capture.photos);
  for (const ColmapPhoto& photo : model.photos) {
    const std::filesystem::path file = images.find(photo.name);
    if (file.empty()) missing.push_back(photo.name);
    add_photo(photo, file, names, capture);
  }
  for (std::string& line : images.lines()) warnings.push_back(std::move(line));
  if (names.empty())
    throw InputError(
        fmt::format("{}: none of the {} photos with a pose is there ({}); put them there, or pass "
                    "--images with the name of their folder",
                    capture.photos.string(), missing.size(), listed_names(missing)));
  note_missing(capture.photos, missing, "the COLMAP model", strict, warnings);
  count_unregistered(capture, strict, warnings);
  for (const std::filesystem::path& file : model.files)
    capture.files.emplace_back(file.lexically_relative(capture.folder).generic_string(), file);
  capture.points = std::move(model.points);
  capture.origin = model.origin;
  capture.prepared_from_source = less(model.origin);
  capture.test_every = kTestEvery;
  capture.posed = true;
}

Capture read_colmap_layout(const std::filesystem::path& folder, const IngestOptions& options) {
  ColmapModel model = read_capture_model(folder);
  Capture capture = photo_set(folder, options, "colmap");
  take_photos(std::move(model), options.strict, capture);
  return capture;
}

Capture read_llff_layout(const std::filesystem::path& folder, const IngestOptions& options) {
  Capture capture = photo_set(folder, options, "llff");
  take_photos(read_llff_photos(folder / "poses_bounds.npy", capture.photos), options.strict,
              capture);
  capture.points_file = "";
  return capture;
}

Capture read_photo_layout(const std::filesystem::path& folder, const IngestOptions& options) {
  Capture capture = photo_set(folder, options, "photos");
  capture.posed = false;
  if (!options.image_layout && looks_like_video(capture.photos))
    capture.notes.push_back(fmt::format(
        "{}: consecutive images are read as photos of a scene that stands still; pass --layout "
        "moving if they are frames of one camera and something moves",
        capture.photos.string()));
  return capture;
}

}  // namespace tessera
