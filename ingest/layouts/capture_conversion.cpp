// Implements ingest_capture: checks the options, finds the layout, stages the folder and calls the
// converter.
#include "ingest/layouts/conversion.h"

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
#include "ingest/files/png.h"
#include "ingest/images/alpha_and_mask.h"
#include "ingest/images/resampling.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/layouts/unread_files.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

void check_options(const IngestOptions& options) {
  if (!(options.scale > 0 && options.scale <= 1))
    throw InputError(
        fmt::format("--scale is {}, expected more than 0 and at most 1; pass 0.5 for "
                    "images of half the width",
                    options.scale));
  if (options.frames && *options.frames < 1)
    throw InputError(
        fmt::format("--frames is {}, expected at least 1; leave it out for all", *options.frames));
  if (options.cloud_points < 1)
    throw InputError(
        fmt::format("--cloud-points is {}, expected at least 1; pass --cloud none for "
                    "no points",
                    options.cloud_points));
  if (!options.masks.empty()) require_folder(options.masks);  // before hours of decoding
}

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
        {!o.poses.lens_model.empty(), estimated, "--camera-model", "poses to be estimated"},
        {o.poses.intrinsics_per_camera, estimated, "--intrinsics", "poses to be estimated"}})
    if (row.given && !row.fits)
      throw InputError(fmt::format("{} is given, but this capture ({}) has no {}; leave it out",
                                   row.name, layout.name, row.what));
}

/// Numbers of images become seconds by --fps, which is then used up.
void take_image_rate(IngestOptions& options) {
  if (options.image_rate) return;
  options.image_rate = options.fps.value_or(kImageRate);
  options.fps.reset();
}

Converter* converter_of(CaptureLayout layout) {
  switch (layout) {
    case CaptureLayout::kTransforms:
      return convert_transforms;
    case CaptureLayout::kN3dv:
    case CaptureLayout::kVideos:
    case CaptureLayout::kSequences:
      return convert_videos;
    case CaptureLayout::kColmap:
      return convert_colmap;
    case CaptureLayout::kLlff:
      return convert_llff;
    case CaptureLayout::kPhotos:
      return convert_bare_photos;
  }
  return nullptr;
}

/// As ingest_capture, but errors of the file system are thrown as std::filesystem_error.
IngestReport convert_staged(const std::filesystem::path& capture, const std::filesystem::path& out,
                            IngestOptions options, const IngestProgress& progress) {
  check_options(options);
  const CaptureLayout layout = layout_of(capture, options);
  check_layout_options(row_of(layout), options);
  options.layout = layout;
  if (layout == CaptureLayout::kSequences) take_image_rate(options);
  if (options.work.empty()) options.work = std::filesystem::path(out).concat(".work");
  StagedFolder staged(out, is_prepared_scene(out));
  const IngestProgress report_progress =
      progress ? progress : [](std::string_view, int64_t, int64_t) {};
  Converted converted = converter_of(layout)(capture, staged.path(), options, report_progress);
  const std::vector<PreparedFrame>& frames = converted.scene.frames;
  const bool has_masks = std::any_of(frames.begin(), frames.end(), [](const PreparedFrame& frame) {
    return !frame.mask_path.empty();
  });
  for (std::string& line : unread_files(capture, has_masks))
    converted.report.warnings.push_back(std::move(line));
  finish_scene(converted, layout, staged.path(), options, report_progress);
  converted.report.layout = layout;
  staged.commit();
  return converted.report;
}

}  // namespace

void convert_images(size_t count, const IngestProgress& progress,
                    const std::function<void(size_t)>& convert) {
  const size_t chunk = 4 * size_t(thread_count());
  for (size_t start = 0; start < count; start += chunk) {
    const size_t size = std::min(chunk, count - start);
    std::vector<std::string> errors(size);
    parallel_for(int64_t(size), 1, [&](int64_t begin, int64_t end) {
      for (auto i = size_t(begin); i < size_t(end); ++i) try {
          convert(start + i);
        } catch (const InputError& error) {
          errors[i] = error.what();
        }
    });
    for (const std::string& error : errors)
      if (!error.empty()) throw InputError(error);
    progress("converting images", int64_t(start + size), int64_t(count));
  }
}

Camera scaled_camera(const Camera& camera, double scale) {
  return camera.resized(scaled_side(camera.width, scale), scaled_side(camera.height, scale));
}

void write_prepared_image(const std::filesystem::path& path, Image8 image, double scale) {
  image = scale_image(image, scaled_side(image.width, scale), scaled_side(image.height, scale));
  if (image.channels == 1) image = composite_on(image, {0, 0, 0});  // grey has no alpha: repeated
  write_png(path, image);
}

IngestReport ingest_capture(const std::filesystem::path& capture, const std::filesystem::path& out,
                            const IngestOptions& options, const IngestProgress& progress) {
  try {
    return convert_staged(capture, out, options, progress);
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
