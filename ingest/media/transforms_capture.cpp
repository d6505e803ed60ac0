// What: D-NeRF, NeRF-synthetic, Nerfstudio or prepared captures → prepared scene.
// Not: parsing (transforms_json.h); alpha is kept, the background is chosen when a scene is loaded.
#include <atomic>
#include <map>
#include <set>

#include "ingest/capture_times.h"
#include "ingest/media/conversion.h"
#include "ingest/media/image_source.h"
#include "ingest/media/mask_source.h"
#include "ingest/point_cloud.h"
#include "ingest/source_hash.h"

namespace tessera {
namespace {

/// Keeps the frames of each camera's first `count` instants (its first pictures without times).
void keep_first_instants(TransformsCapture& capture, int64_t count) {
  std::map<std::string, std::set<double>> instants;
  const auto instant_of = [](const TransformsFrame& frame) {
    return frame.time.value_or(double(frame.frame_number));
  };
  for (const TransformsFrame& frame : capture.frames)
    instants[frame.camera_name].insert(instant_of(frame));
  std::erase_if(capture.frames, [&](const TransformsFrame& frame) {
    const std::set<double>& of_camera = instants[frame.camera_name];
    return std::distance(of_camera.begin(), of_camera.find(instant_of(frame))) >= count;
  });
}

PreparedFrame describe(const TransformsFrame& listed, double time) {
  PreparedFrame prepared;
  prepared.file_path = listed.name + ".png";
  prepared.frame.name = listed.name;
  prepared.frame.camera_name = listed.camera_name;
  prepared.frame.frame_number = listed.frame_number;
  prepared.frame.time = time;
  prepared.frame.split = listed.split;
  prepared.frame.camera = listed.camera;
  return prepared;
}

/// Decodes, scales and writes one picture. True when it has alpha.
bool convert_frame(const TransformsFrame& listed, const std::filesystem::path& folder,
                   const IngestOptions& options, PreparedFrame& prepared, SourceFile& source) {
  const double scale = options.scale;
  Image8 picture = read_picture(listed.image);
  Camera& camera = prepared.frame.camera;
  set_intrinsics(camera, listed.intrinsics, picture.width, picture.height, listed.where);
  camera = scaled_camera(camera, scale);
  source = {listed.name + listed.image.extension().string(), source_hash(listed.image)};
  const auto mask = options.masks.empty() ? listed.mask : find_mask(options, source.name);
  prepared.mask_path = write_prepared_mask(
      folder, listed.name, read_mask(mask, picture.width, picture.height, options), scale);
  const bool has_alpha = picture.channels == 4;
  write_prepared_picture(folder / prepared.file_path, std::move(picture), scale);
  return has_alpha;
}

bool convert_frames(const TransformsCapture& capture, const std::filesystem::path& folder,
                    const IngestOptions& options, const IngestProgress& progress,
                    PreparedScene& scene) {
  std::atomic<bool> had_alpha{false};
  convert_pictures(capture.frames.size(), progress, [&](size_t i) {
    if (convert_frame(capture.frames[i], folder, options, scene.frames[i], scene.sources[i]))
      had_alpha = true;
  });
  return had_alpha;
}

}  // namespace

Converted convert_transforms(const std::filesystem::path& capture_folder,
                             const std::filesystem::path& folder, const IngestOptions& options,
                             const IngestProgress& progress) {
  TransformsCapture capture = read_transforms(capture_folder);
  if (options.frames) keep_first_instants(capture, *options.frames);
  const NormalisedTimes times = times_of(capture, options.allow_static);
  PreparedScene scene;
  scene.layout = "transforms";
  scene.scale = options.scale;
  scene.time_axis = times.axis;
  scene.is_static = times.is_static;
  IngestReport report;
  report.warnings = std::move(capture.warnings);
  std::set<std::string> cameras;
  for (size_t i = 0; i < capture.frames.size(); ++i) {
    scene.frames.push_back(describe(capture.frames[i], times.time[i]));
    if (cameras.insert(capture.frames[i].camera_name).second)
      scene.cameras.push_back({capture.frames[i].camera_name, {}, 0});
  }
  scene.sources.resize(capture.frames.size());
  const bool had_alpha = convert_frames(capture, folder, options, progress, scene);
  scene.background = had_alpha ? "alpha kept" : "opaque";
  for (const std::filesystem::path& file : capture.files)
    scene.sources.push_back({file.filename().string(), source_hash(file)});
  PointCloud points = find_points(capture_folder, capture.points_file, report.warnings);
  report.frames = int64_t(scene.frames.size());
  report.cameras = int64_t(cameras.size());
  return {std::move(scene), std::move(points), std::move(report)};
}

}  // namespace tessera
