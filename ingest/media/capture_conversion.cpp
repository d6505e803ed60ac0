// What: ingest_capture: options checked, layout found, folder staged, converter called.
// Not: any reading of frames; the converters do that.
#include <fmt/format.h>

#include "ingest/alpha_composite.h"
#include "ingest/files/png.h"
#include "ingest/files/staged_folder.h"
#include "ingest/media/conversion.h"
#include "ingest/media/picture_scale.h"
#include "ingest/point_cloud.h"
#include "ingest/transforms_json.h"
#include "kernels/base/errors.h"

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
}

}  // namespace

Camera scaled_camera(const Camera& camera, double scale) {
  return camera.resized(scaled_side(camera.width, scale), scaled_side(camera.height, scale));
}

void write_prepared_picture(const std::filesystem::path& path, Image8 image, double scale) {
  image = scale_picture(image, scaled_side(image.width, scale), scaled_side(image.height, scale));
  if (image.channels == 1) image = composite_on(image, {0, 0, 0});  // grey has no alpha: repeated
  write_png(path, image);
}

void carry_points(const std::filesystem::path& capture, const std::string& stated,
                  const std::filesystem::path& folder, PreparedScene& scene, IngestReport& report) {
  const PointCloud points = find_points(capture, stated, report.warnings);
  report.points = int64_t(points.position.size());
  scene.has_points = report.points > 0;
  if (scene.has_points) write_points(folder / "points.ply", points);
}

IngestReport ingest_capture(const std::filesystem::path& capture, const std::filesystem::path& out,
                            const IngestOptions& options, const IngestProgress& progress) {
  check_options(options);
  const CaptureLayout layout = detect_layout(capture);
  if (layout == CaptureLayout::kVideos)
    throw InputError(fmt::format(
        "{}: videos without poses; add poses_bounds.npy (LLFF order, one row a video) or a "
        "transforms.json with frames: estimating poses is not in this version",
        capture.string()));
  StagedFolder staged(out, is_prepared_scene(out));
  const IngestProgress report_progress =
      progress ? progress : [](std::string_view, int64_t, int64_t) {};
  IngestReport report = layout == CaptureLayout::kN3dv
                            ? convert_n3dv(capture, staged.path(), options, report_progress)
                            : convert_transforms(capture, staged.path(), options, report_progress);
  report.layout = layout;
  staged.commit();
  return report;
}

}  // namespace tessera
