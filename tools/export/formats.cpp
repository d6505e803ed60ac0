// Writes the model file and numbered frames. static3d and recon4d/model/model_file.h encode the
// formats.
#include "tools/export/formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/counted.h"
#include "recon4d/model/element_edits.h"
#include "recon4d/model/model_file.h"
#include "static3d/formats/frame_sequence.h"
#include "static3d/transform/world_change.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/export/line_export.h"
#include "tools/export/page_head.h"
#include "tools/export/player_files.h"
#include "tools/export/tessera4d_export.h"
#include "tools/session/output_folder.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Leaves out what no program can draw; returns how many.
int64_t drop_invalid(GaussianSet& set) {
  const std::vector<int64_t> rows = valid_elements(set);
  const int64_t dropped = set.count() - int64_t(rows.size());
  if (dropped > 0) set = select_elements(set, rows);
  return dropped;
}

json write_model(const ExportRequest& request, Clip& clip) {
  if (clip.count() > 1)
    throw InputError(fmt::format(
        "{}: has {} windows, and --format model holds one model; name the run of a window "
        "(RUN/windows/0000), or take --format tessera, page, html or frames (ply, spz, …)",
        request.model, clip.count()));
  GaussianModel& model = *clip.head;
  const int64_t dropped = drop_invalid(model.static_set) + drop_invalid(model.dynamic_set);
  OutputFolder folder(request.out, "export", {"model.ply"}, request.overwrite);
  save_model(folder.path("model.ply"), model);
  const auto bytes = fs::file_size(folder.path("model.ply"));
  folder.finish();
  return {
      {"frames", 1}, {"bytes", bytes}, {"max_gaussians", model.count()}, {"non_finite", dropped}};
}

std::vector<TimeFormat> with_lines(std::vector<TimeFormat> rows) {
  for (const LineFormat& format : line_formats())
    rows.push_back({format.name, format.doc, export_lines, false});
  return rows;
}

/// One static Gaussian without bands, in the source's world of a scene and on its clock.
GaussianModel least_model(const std::string& path) {
  const Scene scene = scene_without_pixels(path, true);
  GaussianModel model;
  model.static_set = GaussianSet(SetForm::kStatic, 1);
  model.static_set.resize(1);
  const GaussianSpans<float> to = model.static_set.values();
  for (int g = 0; g < model.static_set.groups(); ++g)
    std::fill_n(to.group[g].data, to.group[g].size, 0.0f);
  to.at(kRotation, 0)[0] = 1;
  model.drawing.sh_degree = 0;
  model.time_axis = scene.time_axis;
  model.prepared_from_source = scene.prepared_from_source;
  return model_in_source_world(model);
}

std::vector<std::string> files_of(const ExportRequest& request, int64_t count,
                                  const SplatFormat& format, const Poster& poster) {
  std::vector<std::string> files{"manifest.json"};
  if (request.page) files.emplace_back(kPageFile);
  if (!poster.bytes.empty()) files.push_back(poster.file());
  for (int64_t i = 0; i < count; ++i) files.push_back(sequence_file_name(i, count, format));
  return files;
}

/// One line of all frames, with the number of the one that lost most.
void warn_of_range(const ExportRequest& request, const SequenceReport& report) {
  int64_t most = 0;
  for (const SequenceFrame& frame : report.frames) most = std::max(most, frame.out_of_range);
  if (most == 0) return;
  warn(
      fmt::format("{}: {}{} left out: too far from the others for the range of "
                  "--format {}; ply keeps them",
                  request.out, report.frames.size() > 1 ? "in a frame up to " : "",
                  counted(most, "Gaussian"), request.format));
}

}  // namespace

Tessera4dOptions tessera4d_options(const ExportRequest& request, const GaussianModel& model) {
  Tessera4dOptions options;
  options.segment_seconds = request.segment_seconds;
  options.lossless = request.lossless;
  Rig rig = rig_of(request.cameras, request.model, model);
  options.cameras = std::move(rig.cameras);
  options.fps = request.times.fps.value_or(rig.fps);
  if (!request.audio.empty()) options.audio = fs::path(request.audio).filename().string();
  options.generator = fmt::format("tessera {}", kVersionText);
  return options;
}

const std::vector<TimeFormat>& time_formats() {
  static const std::vector<TimeFormat> rows = with_lines({
      {"tessera", "Tessera 4D: manifest.json and blocks that players stream; --single: one .t4d",
       export_tessera4d},
      {"page", "the same with the web player, for a web server", export_tessera4d},
      {"html", "player and model in one .html that opens by itself", export_tessera4d},
      {"model", "one 4D .ply, bit for bit as trained", write_model, false, false, true},
  });
  return rows;
}

const TimeFormat* find_time_format(const std::string& name) {
  for (const TimeFormat& format : time_formats())
    if (name == format.name) return &format;
  return nullptr;
}

int64_t shipped_bytes(const std::string& path, const GaussianModel& model) {
  ExportRequest request;
  request.model = path;
  const GaussianModel exported = model_in_source_world(model);
  const Tessera4dFile file = encode_tessera4d(exported, tessera4d_options(request, exported));
  return int64_t(single_tessera4d(file).size());
}

ShippedBytes shipped_bytes_of(const std::string& path) {
  return [path](const GaussianModel& model) { return shipped_bytes(path, model); };
}

void check_max_bytes(const std::string& scene, int64_t max_bytes) {
  if (max_bytes == 0) return;
  const GaussianModel model = least_model(scene);
  ExportRequest request;
  request.cameras = scene;
  const Tessera4dOptions options = tessera4d_options(request, model);
  const auto least = int64_t(single_tessera4d(encode_tessera4d(model, options)).size());
  if (max_bytes >= least) return;
  throw InputError(
      fmt::format("--max-bytes {}: the file of one Gaussian with the {} camera poses of {} has {} "
                  "bytes; pass more",
                  max_bytes, options.cameras.size(), scene, least));
}

json export_frames(const ExportRequest& request, const Clip& clip) {
  const GaussianModel& model = *clip.head;
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
    report = folder.written([&] {
      return export_sequence(model, folder.staging(), times, format, progress, hints, clip.windows);
    });
  }
  if (request.page) write_text_file(folder.path(kPageFile), page_of_folder(head));
  if (!head.poster.bytes.empty())
    write_text_file(folder.path(head.poster.file()), head.poster.bytes);
  folder.finish();
  warn_of_range(request, report);
  json result = {{"frames", report.frames.size()},        {"bytes", report.bytes},
                 {"max_gaussians", report.max_gaussians}, {"non_finite", report.non_finite},
                 {"below_cutoff", report.below_cutoff},   {"far_outliers", report.far_outliers},
                 {"out_of_range", report.out_of_range}};
  if (clip.count() > 1)
    result.update({{"windows", clip.count()}, {"peak_gaussians", report.max_gaussians}});
  return result;
}

}  // namespace tessera
