// Implements ingest_capture: checks the options, finds the layout, stages the folder, and takes the
// capture from step to step.
#include "ingest/steps/steps.h"

extern "C" {
#include <libavutil/avutil.h>
}

#include <OpenImageIO/oiioversion.h>
#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core/version.hpp>
#include <string>
#include <vector>

#include "ingest/files/folders.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/layouts/unread_files.h"
#include "ingest/prepared/transforms_json.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Options that some layouts alone have.
void check_layout_options(const LayoutRow& layout, const IngestOptions& o) {
  const bool videos = layout.clips, photos = layout.photos, estimated = layout.estimates_poses;
  struct Row {
    bool given, fits;
    const char *name, *what;
  };
  for (const Row& row :
       {Row{!o.images.empty(), photos, "--images", "photos"},
        {o.frames.has_value(), !photos, "--frames", "several timesteps"},
        {o.start != 0, videos, "--start", "videos"},
        {o.duration.has_value(), videos, "--duration", "videos"},
        {o.fps.has_value(), videos, "--fps", "videos"},
        {!o.cameras.empty(), videos, "--cameras", "videos"},
        {!o.sync.offsets.empty(), videos, "--offsets", "videos"},
        {!o.readouts.empty(), videos, "--readout", "videos"},
        {!o.poses.lens_model.empty(), estimated, "--camera-model", "poses to be estimated"},
        {o.poses.intrinsics_per_camera(), estimated, "--intrinsics", "poses to be estimated"}})
    if (row.given && !row.fits)
      throw InputError(fmt::format("{} is given, but this capture ({}) has no {}; leave it out",
                                   row.name, layout.name, row.what));
}

/// A sample need not show motion, and shares of what is seen are known by fewer points.
void take_sample(IngestOptions& options) {
  constexpr int64_t kMostPoints = 5000;
  options.allow_static = true;
  options.cloud_points = std::min(options.cloud_points, kMostPoints);
}

/// Numbers of images become seconds by --fps, which is then used up; those of one number are of one
/// timestep unless a method is stated.
void take_image_rate(IngestOptions& options) {
  if (options.sync.method == SyncMethod::kAuto) options.sync.method = SyncMethod::kNone;
  if (options.image_rate) return;
  options.image_rate = options.fps.value_or(kImageRate);
  options.fps.reset();
}

/// Of a capture as it was read: later steps leave cameras and frames out.
void name_unread_files(const IngestOptions& options, Capture& capture) {
  const UnreadFiles unread =
      unread_files(capture.folder, taken_files(capture), options.masks, !capture.clips.empty());
  capture.warnings.insert(capture.warnings.end(), unread.warnings.begin(), unread.warnings.end());
  capture.notes.insert(capture.notes.end(), unread.notes.begin(), unread.notes.end());
}

Capture name_unused_masks(Capture capture, const StepContext&) {
  const bool has_masks = std::any_of(capture.frames.begin(), capture.frames.end(),
                                     [](const CaptureFrame& frame) { return !frame.mask.empty(); });
  if (has_masks) return capture;
  if (std::string line = unused_masks(capture.folder); !line.empty())
    capture.warnings.push_back(std::move(line));
  return capture;
}

constexpr Step* kSteps[] = {open_clips,   pose_cameras,  pose_frames,       state_readouts,
                            align_clocks, choose_frames, choose_splits,     set_times,
                            find_masks,   write_images,  name_unused_masks, check_masks,
                            read_points,  finish_scene};

IngestReport report_of(Capture capture, CaptureLayout layout) {
  IngestReport report;
  report.layout = layout;
  report.frames = int64_t(capture.frames.size());
  report.cameras = int64_t(capture.cameras.size());
  report.points = int64_t(capture.points.position.size());
  TestViews test_views;
  for (const CaptureFrame& frame : capture.frames) test_views.add(frame.frame);
  report.test_views = test_views.count();
  report.scored = test_views.text();
  report.warnings = std::move(capture.warnings);
  report.notes = std::move(capture.notes);
  report.camera_table = std::move(capture.camera_table);
  return report;
}

/// As ingest_capture, but errors of the file system are thrown as std::filesystem_error.
IngestReport ingest_staged(const std::filesystem::path& folder, const std::filesystem::path& out,
                           IngestOptions options, const IngestProgress& progress) {
  if (options.sample) take_sample(options);
  const CaptureLayout layout = layout_of(folder, options);
  check_layout_options(row_of(layout), options);
  options.layout = layout;
  if (layout == CaptureLayout::kSequences) take_image_rate(options);
  if (options.work.empty()) options.work = std::filesystem::path(out).concat(".work");
  StagedFolder staged(out, is_prepared_scene(out), files_of_scene(out));
  const IngestProgress report_progress =
      progress ? progress : [](std::string_view, int64_t, int64_t) {};
  const StepContext context{options, staged.path(), report_progress};
  Capture capture = row_of(layout).read(folder, options);
  name_unread_files(options, capture);
  for (Step* step : kSteps) capture = step(std::move(capture), context);
  staged.commit();
  return report_of(std::move(capture), layout);
}

/// As ingest_staged; errors also name what lies there and is not read.
IngestReport ingest_named(const std::filesystem::path& folder, const std::filesystem::path& out,
                          const IngestOptions& options, const IngestProgress& progress) {
  try {
    return ingest_staged(folder, out, options, progress);
  } catch (const AmbiguousCapture&) {
    throw;
  } catch (const InputError& error) {
    throw InputError(with_unread_files(error.what(), folder));
  }
}

}  // namespace

IngestReport ingest_capture(const std::filesystem::path& capture, const std::filesystem::path& out,
                            const IngestOptions& options, const IngestProgress& progress) {
  try {
    check_values(options);
    if (!options.masks.empty()) require_folder(options.masks);  // before hours of decoding
    return ingest_named(capture, out, options, progress);
  } catch (const std::filesystem::filesystem_error& error) {  // link loops, folders without access
    throw InputError(fmt::format("{}: cannot be reached ({}); check this path and its permissions",
                                 error.path1().string(), error.code().message()));
  }
}

// FFmpeg's version is that of the library in use; the others are those of the build.
std::vector<std::pair<std::string, std::string>> media_versions() {
  return {
      {"FFmpeg", av_version_info()}, {"OpenCV", CV_VERSION}, {"OpenImageIO", OIIO_VERSION_STRING}};
}

}  // namespace tessera
