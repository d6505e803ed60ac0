// Estimates a pose for each photo, or for each frame of one moving camera, as a COLMAP model.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/colmap_workspace.h"
#include "ingest/colmap/pose_cache.h"
#include "ingest/colmap/pose_estimation.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "ingest/images/image_paths.h"
#include "ingest/images/image_source.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr size_t kExhaustive = 500;     // images; beyond, all pairs take hours
constexpr const char* kOverlap = "20";  // of an image in order, that it is matched with
constexpr const char* kMoreImages = "take more images, each seeing much of what the one before saw";

std::vector<std::filesystem::path> images_below(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && is_image_name(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (files.size() < 2)
    throw InputError(fmt::format("{}: holds {} images, expected at least 2 for camera poses",
                                 folder.string(), files.size()));
  return files;
}

std::vector<std::string> names_of(const std::vector<std::filesystem::path>& files) {
  std::vector<std::string> names;
  for (const auto& file : files) names.push_back(file.filename().string());
  return names;
}

/// Whether most pixels of images that are spread over all keep their colour.
bool stands_still(const std::vector<std::filesystem::path>& files) {
  constexpr size_t kImages = 5;
  constexpr int kAlike = 8;  // levels
  std::vector<Image8> images;
  for (size_t i = 0; i < std::min(kImages, files.size()); ++i)
    images.push_back(read_image(files[i * files.size() / std::min(kImages, files.size())]));
  size_t still = 0;
  const size_t bytes = images.front().data.size();
  for (size_t b = 0; b < bytes; ++b)
    still += std::all_of(images.begin(), images.end(), [&](const Image8& image) {
      return image.data.size() == bytes &&
             std::abs(image.data[b] - images.front().data[b]) <= kAlike;
    });
  return 2 * still > bytes;
}

}  // namespace

MovingCameraModel estimate_moving_camera(const std::filesystem::path& images, bool in_order,
                                         const std::filesystem::path& folder,
                                         const PoseOptions& options,
                                         const IngestProgress& progress) {
  const auto files = images_below(images);
  const ColmapWorkspace work(folder);
  const ColmapProgram colmap(work.folder / "colmap.log", progress);
  const std::string lens = options.lens_model.empty() ? "SIMPLE_RADIAL" : options.lens_model;
  Fnv1a key;
  key.add(fmt::format("moving 1, colmap {}, {} {} {}", colmap.version(), lens,
                      options.intrinsics_per_camera(), in_order));
  for (const auto& file : files) key.add(file.string() + " " + source_hash(file) + "\n");
  MovingCameraModel result;
  result.images = files.size();
  const PoseCache cache(in_order ? std::filesystem::path() : options.cache);  // not of a video
  if (!work.holds(key.hex())) {
    work.clear();
    result.reused = cache.fetch(key.hex(), work);
  }
  const bool is_known = work.holds(key.hex());
  if (!is_known) {
    const std::string source = std::filesystem::absolute(images).string();
    const std::string database = work.database.string();
    ColmapOptions reading{{"--database_path", database},
                          {"--image_path", source},
                          {"--ImageReader.camera_model", lens}};
    if (!options.intrinsics_per_camera())
      reading.emplace_back(
          in_order ? "--ImageReader.single_camera" : "--ImageReader.single_camera_per_folder", "1");
    colmap.extract_features(reading, int64_t(files.size()));
    if (in_order || files.size() > kExhaustive)
      colmap.match_features("sequential_matcher", {{"--database_path", database},
                                                   {"--SequentialMatching.overlap", kOverlap}});
    else
      colmap.match_features("exhaustive_matcher", {{"--database_path", database}});
    make_folder(work.sparse);
    try {
      colmap.run("mapper",
                 {{"--database_path", database},
                  {"--image_path", source},
                  {"--output_path", work.sparse.string()}},
                 "colmap: registering images", "Registering image", int64_t(files.size()),
                 kMoreImages);
    } catch (const ColmapFailure& failure) {
      if (in_order && stands_still(files))
        throw InputError(fmt::format(
            "{}: the camera does not move, and one camera that stands still shows no depth; film "
            "with two cameras or more, or move this one",
            images.string()));
      failure.rethrow(names_of(files), kMoreImages);
    }
  }
  result.folder = largest_colmap_model(work.sparse, files.size(), result.warnings);
  if (result.folder.empty())
    throw InputError(fmt::format("{}: COLMAP made no model of it; {}; its log: {}", images.string(),
                                 kMoreImages, colmap.log().string()));
  const size_t registered = read_colmap_model(result.folder).photos.size();
  // not before the model was read: its files may be incomplete
  if (!is_known) {
    work.store_key(key.hex());
    cache.keep(key.hex(), work);
  }
  const std::string seen = fmt::format("{}: COLMAP registered {} of {} images", images.string(),
                                       registered, files.size());
  if (registered < files.size() && options.strict)
    throw InputError(fmt::format("{} (log: {}); leave --strict out to go on without the others",
                                 seen, colmap.log().string()));
  if (registered < files.size()) result.warnings.push_back(seen);
  return result;
}

}  // namespace tessera
