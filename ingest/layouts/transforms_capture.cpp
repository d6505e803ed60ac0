// Converts D-NeRF, NeRF-synthetic, Nerfstudio and prepared captures to a prepared scene. Alpha is
// kept; the background is chosen when a scene is loaded.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "ingest/files/fnv1a.h"
#include "ingest/files/point_cloud.h"
#include "ingest/images/resampling.h"
#include "ingest/layouts/conversion.h"
#include "ingest/layouts/image_intake.h"
#include "ingest/layouts/mask_source.h"
#include "ingest/prepared/transforms_json.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Keeps the frames of each camera's first `count` instants (its first images without times).
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

/// The splits by --held-out or --test-every. Errors: InputError: the capture states test
/// frames itself, a wrong name or number, nothing left to train on.
void choose_splits(TransformsCapture& capture, const IngestOptions& options) {
  if (options.held_out.empty() && !options.test_every) return;
  std::vector<std::string> frames, cameras;
  for (const TransformsFrame& frame : capture.frames) {
    frames.push_back(frame.name);
    if (std::find(cameras.begin(), cameras.end(), frame.camera_name) == cameras.end())
      cameras.push_back(frame.camera_name);
    if (frame.split != Split::kTrain)
      throw InputError(fmt::format(
          "{}: is stated as a test frame, but {} is given; leave the option out, or remove the "
          "stated split",
          frame.where, options.test_every ? "--test-every" : "--held-out"));
  }
  if (options.test_every) {
    const std::vector<Split> splits = every_nth_split(frames, *options.test_every);
    for (size_t i = 0; i < frames.size(); ++i) capture.frames[i].split = splits[i];
    return;
  }
  const std::vector<Split> splits = held_out_splits_of(cameras, options.held_out, "transforms");
  for (TransformsFrame& frame : capture.frames) {
    const auto camera = std::find(cameras.begin(), cameras.end(), frame.camera_name);
    frame.split = splits[size_t(camera - cameras.begin())];
  }
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

/// Undistorts, scales and writes one image.
void convert_frame(const TransformsFrame& listed, Image8 image, const std::filesystem::path& folder,
                   const IngestOptions& options, PreparedFrame& prepared) {
  Camera& camera = prepared.frame.camera;
  set_intrinsics(camera, listed.intrinsics, image.width, image.height, listed.where);
  const auto file = options.masks.empty()
                        ? listed.mask
                        : find_mask(options, listed.name + listed.image.extension().string());
  Image8 mask = read_mask(file, image.width, image.height, options);
  if (!listed.lens.lens.is_pinhole()) {
    const Camera pinhole = undistorted_camera(
        camera, listed.lens.lens, fmt::format("{} ({})", listed.where, listed.lens.model));
    image = Undistortion(camera, listed.lens.lens, pinhole).apply(image);
    mask = undistorted_mask(mask, camera, listed.lens.lens, pinhole);
    camera = pinhole;
  }
  camera = scaled_camera(camera, options.scale);
  prepared.mask_path = write_prepared_mask(folder, listed.name, mask, options.scale);
  write_prepared_image(folder / prepared.file_path, std::move(image), options.scale);
}

/// Frames and cameras, without the values that depend on the images.
PreparedScene describe(const TransformsCapture& capture, const NormalisedTimes& times,
                       double scale) {
  PreparedScene scene;
  scene.layout = "transforms";
  scene.scale = scale;
  scene.time_axis = times.axis;
  scene.prepared_from_source = capture.prepared_from_source;
  scene.is_static = times.is_static;
  std::map<std::string, size_t> cameras;  // name → index
  for (size_t i = 0; i < capture.frames.size(); ++i) {
    const TransformsFrame& frame = capture.frames[i];
    scene.frames.push_back(describe(frame, times.time[i]));
    scene.sources.push_back({frame.name + frame.image.extension().string(), ""});
    const auto [camera, is_new] = cameras.emplace(frame.camera_name, scene.cameras.size());
    if (is_new) scene.cameras.push_back({frame.camera_name, {}, 0, {}});
    note_removed_lens(scene.cameras[camera->second], {frame.lens.model, frame.lens.lens});
  }
  return scene;
}

}  // namespace

Converted convert_transforms(const std::filesystem::path& capture_folder,
                             const std::filesystem::path& folder, const IngestOptions& options,
                             const IngestProgress& progress) {
  TransformsCapture capture = read_transforms_capture(capture_folder);
  IngestReport report;
  report.warnings = std::move(capture.warnings);
  note_missing(capture_folder, capture.missing, "the transforms file", options.strict,
               report.warnings);
  choose_splits(capture, options);
  const TimeAxis whole = times_of(capture, true).axis;
  if (options.frames) keep_first_instants(capture, *options.frames);
  const NormalisedTimes times = times_of(capture, options.allow_static);
  PreparedScene scene = describe(capture, times, options.scale);
  ImageIntake intake(capture.frames.size());
  convert_images(capture.frames.size(), progress, [&](size_t i) {
    const TransformsFrame& frame = capture.frames[i];
    auto image =
        intake.read(i, frame.image, frame.intrinsics.w.value_or(0), frame.intrinsics.h.value_or(0));
    if (!image) return;
    convert_frame(frame, std::move(*image), folder, options, scene.frames[i]);
    scene.sources[i].hash = source_hash(frame.image);
  });
  intake.finish(scene, options.strict, report.warnings);
  for (const std::filesystem::path& file : capture.files)
    scene.sources.push_back({file.filename().string(), source_hash(file)});
  PointCloud points = find_points(capture_folder, capture.points_file, report.warnings);
  change_time_axis(points, whole, times.axis);
  report.frames = int64_t(scene.frames.size());
  report.cameras = int64_t(scene.cameras.size());
  return {std::move(scene), std::move(points), std::move(report)};
}

}  // namespace tessera
