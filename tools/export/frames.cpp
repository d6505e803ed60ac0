// What: the folder, its files, progress.
// Not: frames themselves (static3d/formats/frame_sequence.h).
#include "tools/export/frames.h"

#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "static3d/formats/frame_sequence.h"
#include "tools/camera_paths/rig_cameras.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/export/output_folder.h"
#include "tools/export/player_files.h"

namespace tessera {
namespace {

std::vector<std::string> files_of(const ExportRequest& request, int64_t count,
                                  const SplatFormat& format, const Poster& poster) {
  std::vector<std::string> files{"manifest.json"};
  if (request.page) files.emplace_back(kPageFile);
  if (!poster.bytes.empty()) files.push_back(poster.file());
  for (int64_t i = 0; i < count; ++i) files.push_back(sequence_file_name(i, count, format));
  return files;
}

}  // namespace

nlohmann::json export_frames(const ExportRequest& request, const GaussianModel& model) {
  const SplatFormat format =
      request.format == "spz" ? spz_format(request.spz_version) : splat_format(request.format);
  if (request.page) check_page_plays(format);
  Rig rig = rig_of(request.page ? request.cameras : "", request.model, model);
  ExportTimes wanted = request.times;
  if (rig.fps > 0) wanted.capture_fps = rig.fps;
  const std::vector<double> times = export_times(wanted, model.time_axis, model.moves());
  const PageHead head = request.page ? page_head(request, model) : PageHead{};
  OutputFolder folder(request.out, "export",
                      files_of(request, int64_t(times.size()), format, head.poster),
                      request.overwrite);
  SequenceHints hints;
  if (request.page) hints.cameras = std::move(rig.cameras);
  SequenceReport report;
  {
    ProgressBar bar("export");
    const auto progress = [&](int64_t done, int64_t total) {
      stop_if_interrupted();
      bar.update(done, total);
    };
    report = export_sequence(model, folder.staging(), times, format, progress, hints);
  }
  if (request.page) write_text_file(folder.path(kPageFile), page_of_folder(head));
  if (!head.poster.bytes.empty())
    write_text_file(folder.path(head.poster.file()), head.poster.bytes);
  folder.finish();
  return {{"frames", report.frames.size()},        {"bytes", report.bytes},
          {"max_gaussians", report.max_gaussians}, {"non_finite", report.non_finite},
          {"below_cutoff", report.below_cutoff},   {"far_outliers", report.far_outliers}};
}

}  // namespace tessera
