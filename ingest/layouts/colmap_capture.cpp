// Converts a folder of photos with a COLMAP model, the poses of LLFF or estimated poses to a static
// prepared scene with pinhole images.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/pose_estimation.h"
#include "ingest/files/fnv1a.h"
#include "ingest/files/point_cloud.h"
#include "ingest/images/image_index.h"
#include "ingest/images/image_paths.h"
#include "ingest/images/resampling.h"
#include "ingest/layouts/conversion.h"
#include "ingest/layouts/image_intake.h"
#include "ingest/layouts/image_sequences.h"
#include "ingest/layouts/mask_source.h"
#include "ingest/poses/intrinsics.h"
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

constexpr int64_t kTestEvery = 8;  // the usual protocol for photo sets

struct FoundPhoto {
  ColmapPhoto photo;
  std::filesystem::path file;
  std::string name;  // photo.name without extension, where that is unique
  Split split = Split::kTrain;
};

/// `images` or the folder that is named; where neither is there, the only one called images_N.
std::filesystem::path image_folder(const std::filesystem::path& capture, const std::string& named) {
  const auto stated = capture / (named.empty() ? "images" : named);
  if (std::filesystem::is_directory(stated)) return stated;
  std::vector<std::string> others;
  for (const auto& entry : std::filesystem::directory_iterator(capture))
    if (entry.is_directory() && entry.path().filename().string().starts_with("images"))
      others.push_back(entry.path().filename().string());
  std::sort(others.begin(), others.end());
  if (named.empty() && others.empty() && !images_in(capture).empty()) return capture;
  if (named.empty() && others.size() == 1) return capture / others.front();
  throw InputError(fmt::format(
      "{}: no such folder; {}", stated.string(),
      others.empty() ? "put the photos that the poses were made of there"
                     : fmt::format("pass --images with one of {}", listed_names(others))));
}

void count_unregistered(const std::filesystem::path& folder, const std::vector<FoundPhoto>& found,
                        bool strict, std::vector<std::string>& warnings) {
  std::set<std::filesystem::path> registered;
  for (const FoundPhoto& photo : found) registered.insert(photo.file.lexically_normal());
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

/// The photos of the model whose files are there, by name. The split goes by the model's list, so
/// that a photo that is missing does not change that of the others.
std::vector<FoundPhoto> find_photos(ColmapModel& model, const std::filesystem::path& folder,
                                    int64_t test_every, bool strict,
                                    std::vector<std::string>& warnings) {
  std::vector<FoundPhoto> found;
  std::vector<std::string> missing;
  std::vector<std::string> stated;
  for (const ColmapPhoto& photo : model.photos) stated.push_back(photo.name);
  const std::vector<Split> splits = every_nth_split(stated, test_every);
  std::set<std::string> names;
  ImageIndex images(folder);
  for (size_t i = 0; i < model.photos.size(); ++i) {
    ColmapPhoto& photo = model.photos[i];
    const auto file = images.find(photo.name);
    if (file.empty()) {
      missing.push_back(photo.name);
      continue;
    }
    std::string name = name_of_image(photo.name);
    if (!names.insert(name).second) names.insert(name = name_of_image(photo.name + ".png"));
    found.push_back({std::move(photo), file, name, splits[i]});
  }
  for (std::string& line : images.lines()) warnings.push_back(std::move(line));
  if (found.empty())
    throw InputError(
        fmt::format("{}: none of the {} photos with a pose is there ({}); put them there, or pass "
                    "--images with the name of their folder",
                    folder.string(), missing.size(), listed_names(missing)));
  note_missing(folder, missing, "the COLMAP model", strict, warnings);
  count_unregistered(folder, found, strict, warnings);
  return found;
}

void choose_splits(std::vector<FoundPhoto>& photos, const IngestOptions& options,
                   std::vector<std::string>& warnings) {
  if (!options.held_out.empty()) {
    std::vector<std::string> names;
    for (const FoundPhoto& photo : photos) names.push_back(photo.name);
    const auto splits = held_out_splits_of(names, options.held_out, "colmap");
    for (size_t i = 0; i < photos.size(); ++i) photos[i].split = splits[i];
  }
  if (std::any_of(photos.begin(), photos.end(),
                  [](const FoundPhoto& photo) { return photo.split == Split::kTrain; }))
    return;
  if (photos.size() > 1)
    throw InputError(fmt::format(
        "colmap: all {} photos that are there are held out, none is left to train on; pass "
        "--test-every 0",
        photos.size()));
  photos.front().split = Split::kTrain;
  warnings.push_back("colmap: there is one photo only, none is held out for testing");
}

/// Undistorts, scales and writes one photo.
void convert_photo(const FoundPhoto& found, Image8 image, const std::filesystem::path& folder,
                   const IngestOptions& options, PreparedFrame& prepared) {
  const Camera& stated = found.photo.camera;
  if (!same_shape(stated.width, stated.height, image.width, image.height))
    throw InputError(fmt::format(
        "{}: is {}x{}, its pose was made for {}x{}; use the photos that the poses were made of "
        "(not turned), or reduced copies of the same shape",
        found.file.string(), image.width, image.height, stated.width, stated.height));
  Camera camera = stated.resized(image.width, image.height);
  Image8 mask =
      read_mask(find_mask(options, found.photo.name), camera.width, camera.height, options);
  if (!found.photo.lens.is_pinhole()) {
    const Camera pinhole =
        undistorted_camera(camera, found.photo.lens,
                           fmt::format("{} ({})", found.file.string(), found.photo.lens_model));
    image = Undistortion(camera, found.photo.lens, pinhole).apply(image);
    mask = undistorted_mask(mask, camera, found.photo.lens, pinhole);
    camera = pinhole;
  }
  prepared.frame.camera = scaled_camera(camera, options.scale);
  prepared.mask_path = write_prepared_mask(folder, prepared.frame.name, mask, options.scale);
  write_prepared_image(folder / prepared.file_path, std::move(image), options.scale);
}

PreparedScene describe(const std::vector<FoundPhoto>& photos, double scale) {
  PreparedScene scene;
  scene.scale = scale;
  scene.is_static = true;
  for (const FoundPhoto& found : photos) {
    PreparedFrame prepared;
    prepared.frame.name = "images/" + found.name;
    prepared.file_path = prepared.frame.name + ".png";
    prepared.frame.camera_name = found.name;
    prepared.frame.split = found.split;
    scene.frames.push_back(std::move(prepared));
    scene.cameras.push_back({found.name, {}, 0, {}});
    note_removed_lens(scene.cameras.back(), {found.photo.lens_model, found.photo.lens});
  }
  return scene;
}

}  // namespace

Converted convert_photos(const std::filesystem::path& capture, const std::filesystem::path& images,
                         ColmapModel model, const std::filesystem::path& folder,
                         const IngestOptions& options, const IngestProgress& progress) {
  const int64_t test_every = options.test_every.value_or(kTestEvery);
  IngestReport report;
  report.warnings = std::move(model.warnings);
  auto photos = find_photos(model, images, options.held_out.empty() ? test_every : 0,
                            options.strict, report.warnings);
  choose_splits(photos, options, report.warnings);
  PreparedScene scene = describe(photos, options.scale);
  scene.sources.resize(photos.size());
  ImageIntake intake(photos.size());
  convert_images(photos.size(), progress, [&](size_t i) {
    const FoundPhoto& found = photos[i];
    scene.sources[i].name = found.file.lexically_relative(capture).generic_string();
    auto image = intake.read(i, found.file, found.photo.camera.width, found.photo.camera.height);
    if (!image) return;
    convert_photo(found, std::move(*image), folder, options, scene.frames[i]);
    scene.sources[i].hash = source_hash(found.file);
  });
  intake.finish(scene, options.strict, report.warnings);
  for (const auto& file : model.files)
    scene.sources.push_back({file.lexically_relative(capture).generic_string(), source_hash(file)});
  report.frames = report.cameras = int64_t(scene.frames.size());
  return {std::move(scene), std::move(model.points), std::move(report)};
}

Converted convert_colmap(const std::filesystem::path& capture, const std::filesystem::path& folder,
                         const IngestOptions& options, const IngestProgress& progress) {
  ColmapModel model = read_capture_model(capture);
  Converted converted = convert_photos(capture, image_folder(capture, options.images),
                                       std::move(model), folder, options, progress);
  converted.scene.layout = "colmap";
  return converted;
}

Converted convert_bare_photos(const std::filesystem::path& capture,
                              const std::filesystem::path& folder, const IngestOptions& options,
                              const IngestProgress& progress) {
  const auto images = image_folder(capture, options.images);
  MovingCameraModel estimate =
      estimate_moving_camera(images, false, options.work / "colmap", options.poses, progress);
  ColmapModel model = read_colmap_model(estimate.folder);
  const std::string registered = fmt::format(
      "COLMAP registered {} of {} photos, mean reprojection error {:.2f} pixels{}",
      model.photos.size(), estimate.images, model.error, estimate.reused ? kReused : "");
  Converted converted =
      convert_photos(capture, images, std::move(model), folder, options, progress);
  converted.scene.layout = "photos";
  converted.report.notes.push_back(registered);
  if (!options.image_layout && looks_like_video(images))
    converted.report.notes.push_back(fmt::format(
        "{}: consecutive images are read as photos of a scene that stands still; pass --layout "
        "moving if they are frames of one camera and something moves",
        images.string()));
  std::vector<std::string>& warnings = converted.report.warnings;
  warnings.insert(warnings.begin(), estimate.warnings.begin(), estimate.warnings.end());
  return converted;
}

Converted convert_llff(const std::filesystem::path& capture, const std::filesystem::path& folder,
                       const IngestOptions& options, const IngestProgress& progress) {
  const auto images = image_folder(capture, options.images);
  Converted converted =
      convert_photos(capture, images, read_llff_photos(capture / "poses_bounds.npy", images),
                     folder, options, progress);
  converted.scene.layout = "llff";
  converted.points = find_points(capture, "", converted.report.warnings);
  return converted;
}

}  // namespace tessera
