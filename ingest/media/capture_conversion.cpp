// What: ingest_capture: options checked, layout found, folder staged, converter called.
// Not: any reading of frames; the converters do that.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "ingest/alpha_composite.h"
#include "ingest/files/png.h"
#include "ingest/files/staged_folder.h"
#include "ingest/media/conversion.h"
#include "ingest/media/picture_scale.h"
#include "ingest/media/scene_finish.h"
#include "ingest/transforms_json.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

void check_options(const IngestOptions& options) {
  if (!(options.scale > 0 && options.scale <= 1))
    throw InputError(
        fmt::format("--scale is {}, expected more than 0 and at most 1; pass 0.5 for "
                    "pictures of half the width",
                    options.scale));
  if (options.frames && *options.frames < 1)
    throw InputError(
        fmt::format("--frames is {}, expected at least 1; leave it out for all", *options.frames));
  if (options.cloud_points < 1)
    throw InputError(
        fmt::format("--cloud-points is {}, expected at least 1; pass --cloud none for "
                    "no points",
                    options.cloud_points));
}

/// Options that one layout alone has.
void check_layout_options(CaptureLayout layout, const IngestOptions& options) {
  if (layout == CaptureLayout::kColmap || layout == CaptureLayout::kLlff) return;
  for (const auto& [given, name] : {std::pair{!options.pictures.empty(), "--images"},
                                    {options.test_every.has_value(), "--test-every"}})
    if (given)
      throw InputError(
          fmt::format("{} is given, but the capture is not a photo set with poses (COLMAP or "
                      "LLFF); leave it out",
                      name));
}

/// As ingest_capture, but what the file system says comes as its own exception.
IngestReport convert_staged(const std::filesystem::path& capture, const std::filesystem::path& out,
                            const IngestOptions& options, const IngestProgress& progress) {
  check_options(options);
  const CaptureLayout layout = options.layout ? *options.layout : detect_layout(capture);
  check_layout_options(layout, options);
  if (layout == CaptureLayout::kVideos)
    throw InputError(fmt::format(
        "{}: videos without poses; add poses_bounds.npy (LLFF order, one row a video) or a "
        "transforms.json with frames: estimating poses is not in this version",
        capture.string()));
  if (layout == CaptureLayout::kPhotos)
    throw InputError(fmt::format(
        "{}: photos without poses; run COLMAP on them and put its model into sparse/0, or add "
        "poses_bounds.npy or a transforms.json with frames",
        capture.string()));
  StagedFolder staged(out, is_prepared_scene(out));
  const IngestProgress report_progress =
      progress ? progress : [](std::string_view, int64_t, int64_t) {};
  const auto convert = layout == CaptureLayout::kN3dv     ? convert_n3dv
                       : layout == CaptureLayout::kColmap ? convert_colmap
                       : layout == CaptureLayout::kLlff   ? convert_llff
                                                          : convert_transforms;
  Converted converted = convert(capture, staged.path(), options, report_progress);
  finish_scene(converted, layout, staged.path(), options, report_progress);
  converted.report.layout = layout;
  staged.commit();
  return converted.report;
}

}  // namespace

void convert_pictures(size_t count, const IngestProgress& progress,
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
    progress("converting pictures", int64_t(start + size), int64_t(count));
  }
}

Camera scaled_camera(const Camera& camera, double scale) {
  return camera.resized(scaled_side(camera.width, scale), scaled_side(camera.height, scale));
}

void write_prepared_picture(const std::filesystem::path& path, Image8 image, double scale) {
  image = scale_picture(image, scaled_side(image.width, scale), scaled_side(image.height, scale));
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

}  // namespace tessera
