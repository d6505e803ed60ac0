// What: `tessera export`: a model → files for other programs.
// Not: the formats (static3d/splat_file.h, recon4d/model_file.h).
#include <fmt/format.h>

#include <algorithm>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/hygiene.h"
#include "recon4d/model_file.h"
#include "recon4d/nearest_name.h"
#include "static3d/frame_sequence.h"
#include "static3d/world_change.h"
#include "tools/command.h"
#include "tools/export_times.h"
#include "tools/interrupt.h"
#include "tools/model_input.h"
#include "tools/output_folder.h"
#include "tools/terminal.h"

namespace tessera {
namespace {

struct ExportRequest {
  std::string model, out, format = "ply";
  ExportTimes times;
  int threads = 0;
  bool keep_world = false, overwrite = false, json = false;
};

std::vector<std::string> sequence_files(int64_t count, const SplatFormat& format) {
  std::vector<std::string> files{"manifest.json"};
  for (int64_t i = 0; i < count; ++i) files.push_back(sequence_file_name(i, count, format));
  return files;
}

nlohmann::json export_frames(const ExportRequest& request, const GaussianModel& model) {
  const SplatFormat& format = splat_format(request.format);
  const std::vector<double> times =
      export_times(request.times, model.time_axis, model.dynamic_set.count() > 0);
  OutputFolder folder(request.out, "export", sequence_files(int64_t(times.size()), format),
                      request.overwrite);
  SequenceReport report;
  {
    ProgressBar bar("export");
    report = export_sequence(model, request.out, times, format, [&](int64_t done, int64_t total) {
      stop_if_interrupted();
      bar.update(done, total);
    });
  }
  folder.finish();
  return {{"frames", report.frames.size()},        {"bytes", report.bytes},
          {"max_gaussians", report.max_gaussians}, {"non_finite", report.non_finite},
          {"below_cutoff", report.below_cutoff},   {"far_outliers", report.far_outliers}};
}

/// Leaves out what no program can draw; returns how many.
int64_t drop_unsound(GaussianSet& set) {
  const std::vector<int64_t> rows = sound_rows(set);
  const int64_t dropped = set.count() - int64_t(rows.size());
  if (dropped > 0) set = select_rows(set, rows);
  return dropped;
}

nlohmann::json export_tessera(const ExportRequest& request, GaussianModel& model) {
  const int64_t dropped = drop_unsound(model.static_set) + drop_unsound(model.dynamic_set);
  OutputFolder folder(request.out, "export", {"model.ply"}, request.overwrite);
  save_model(folder.path("model.ply"), model);
  folder.finish();
  return {{"frames", 1},
          {"bytes", std::filesystem::file_size(folder.path("model.ply"))},
          {"max_gaussians", model.count()},
          {"non_finite", dropped}};
}

constexpr const char* kTessera = "tessera";  // the format that holds time

void check_format(const std::string& name) {
  std::vector<std::string> names{kTessera};
  for (const SplatFormat& format : splat_formats()) names.push_back(format.name);
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw InputError(fmt::format("export: unknown format '{}'; did you mean '{}'? There are {}",
                                 name, nearest_name(name, names), fmt::join(names, ", ")));
}

/// With the dilation and the cut-off that 3DGS files do not name because all have them.
bool drawn_as_players_do(const GaussianModel& model) {
  return !model.filter_2d && !model.truncation_by_falloff &&
         model.truncation_sigma == kTruncationSigma;
}

/// The files that an earlier export left in the folder are removed; the model must not be one.
void check_places(const ExportRequest& request, const std::filesystem::path& model) {
  std::error_code missing;
  if (std::filesystem::equivalent(std::filesystem::absolute(model).parent_path(), request.out,
                                  missing))
    throw InputError(
        fmt::format("{}: is the folder of the model itself; choose another folder", request.out));
}

int export_command(const ExportRequest& request) {
  check_format(request.format);
  const bool as_frames = request.format != kTessera;
  set_thread_count(request.threads);
  ModelInput input = load_model_input(request.model);
  for (const std::string& warning : input.warnings) warn(warning);
  check_places(request, input.file);
  if (as_frames && !drawn_as_players_do(input.model))
    warn(
        fmt::format("{}: was trained with another filter or truncation than players of 3DGS files "
                    "have; its frames look different there; --format tessera keeps them",
                    input.file.string()));
  if (as_frames && input.model.environment.height > 0)
    warn(
        fmt::format("{}: its environment is not in frames of 3DGS files; --format tessera keeps it",
                    input.file.string()));
  if (!request.keep_world) input.model = model_in_source_world(input.model);
  nlohmann::json result =
      as_frames ? export_frames(request, input.model) : export_tessera(request, input.model);
  result["out"] = request.out, result["format"] = request.format;
  result["model"] = input.file.string(), result["num_gaussians"] = input.model.count();
  const int64_t frames = result["frames"], bytes = result["bytes"];
  print_result(request.json, result,
               fmt::format("{}: {} file{}, {:.1f} MB", request.out, frames, frames == 1 ? "" : "s",
                           double(bytes) / 1e6));
  return kExitDone;
}

void add_times(CLI::App& command, ExportTimes& times) {
  CLI::Option* frames =
      command.add_option("--frames", times.frames, "moments, evenly from first to last");
  CLI::Option* fps =
      command.add_option("--fps", times.fps, "moments a second of the capture's clock");
  CLI::Option* time =
      command.add_option("--time", times.time, "a single moment, 0 (first) to 1 (last)");
  CLI::Option* range = command.add_option(
      "--range", times.range,
      "A:B, that part of the clip: each 0 (first) to 1 (last), or seconds from its beginning (2s)");
  fps->excludes(frames), time->excludes(frames), time->excludes(fps), range->excludes(time);
}

}  // namespace

void add_export_command(CLI::App& app, Work& work) {
  CLI::App* command = app.add_subcommand("export", "write a model for other programs");
  command->option_defaults()->always_capture_default();
  const auto request = std::make_shared<ExportRequest>();
  command
      ->add_option("model", request->model,
                   "run folder, checkpoint, Tessera .ply or other people's splats")
      ->required();
  command->add_option("-o,--out", request->out, "folder to write")->required();
  std::string formats = "\n    tessera     one 4D .ply";
  for (const SplatFormat& format : splat_formats())
    formats +=
        fmt::format("\n    {:<10}  numbered {}: {}", format.name, format.extension, format.doc);
  command->add_option("--format", request->format, "of the files:" + formats);
  add_times(*command, request->times);
  command->add_flag("--keep-world", request->keep_world,
                    "stay in the world of the prepared scene; default: back in the capture's own");
  command->add_flag("--overwrite", request->overwrite, "write among files that are not ours");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return export_command(*request); }; });
}

}  // namespace tessera
