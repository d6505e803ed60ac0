// What: `tessera export`: a model → files for other programs.
// Not: the formats (static3d/splat_file.h, recon4d/model_file.h).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/hygiene.h"
#include "recon4d/model_file.h"
#include "recon4d/nearest_name.h"
#include "static3d/frame_sequence.h"
#include "static3d/world_change.h"
#include "tools/command.h"
#include "tools/export_splatv.h"
#include "tools/interrupt.h"
#include "tools/model_input.h"
#include "tools/output_folder.h"
#include "tools/terminal.h"

namespace tessera {
namespace {

constexpr double kDefaultFps = 24;       // frames per unit of the capture's clock (seconds)
constexpr int64_t kMostDefault = 300;    // frames that nobody asked for
constexpr int64_t kMostFrames = 100000;  // frames that anybody may ask for

struct ExportRequest {
  std::string model, out, format = "ply";
  std::optional<int64_t> frames;
  std::optional<double> fps, time;
  int threads = 0, spz_version = 3;
  bool keep_world = false, overwrite = false, json = false;
};

/// `count` moments from the first to the last.
std::vector<double> spread(int64_t count) {
  std::vector<double> times(static_cast<size_t>(count), 0.0);
  for (size_t i = 1; i < times.size(); ++i) times[i] = double(i) / double(count - 1);
  return times;
}

/// Moments 1/fps apart from the first on.
std::vector<double> at_rate(double fps, double duration) {
  const double last = std::floor(fps * duration + 1e-6);
  if (!(fps > 0) || !(last < double(kMostFrames)))
    throw InputError(
        fmt::format("export: --fps {} over {} seconds makes {} frames, expected 1 to "
                    "{}; pass --frames",
                    fps, duration, last + 1, kMostFrames));
  std::vector<double> times;
  for (int64_t i = 0; i <= int64_t(last); ++i)
    times.push_back(std::min(1.0, double(i) / (fps * duration)));
  return times;
}

std::vector<double> export_times(const ExportRequest& request, const GaussianModel& model) {
  if (request.time) {
    if (!std::isfinite(*request.time)) throw InputError("export: --time must be a finite number");
    return {*request.time};
  }
  if (request.frames) {
    if (*request.frames < 1 || *request.frames > kMostFrames)
      throw InputError(
          fmt::format("export: --frames is {}, expected 1 to {}", *request.frames, kMostFrames));
    return spread(*request.frames);
  }
  if (request.fps) return at_rate(*request.fps, model.time_axis.duration);
  if (model.dynamic_set.count() == 0) return {0.0};
  const double count = std::floor(kDefaultFps * model.time_axis.duration) + 1;
  return spread(int64_t(std::clamp(count, 2.0, double(kMostDefault))));
}

std::vector<std::string> sequence_files(int64_t count, const SplatFormat& format) {
  std::vector<std::string> files{"manifest.json"};
  for (int64_t i = 0; i < count; ++i) files.push_back(sequence_file_name(i, count, format));
  return files;
}

nlohmann::json export_frames(const ExportRequest& request, const GaussianModel& model) {
  const SplatFormat format =
      request.format == "spz" ? spz_format(request.spz_version) : splat_format(request.format);
  const std::vector<double> times = export_times(request, model);
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
  std::vector<std::string> names{kTessera, kSplatv};
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
  const bool as_splatv = request.format == kSplatv;
  const bool as_frames = request.format != kTessera && !as_splatv;
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
  nlohmann::json result = as_splatv   ? export_splatv(request.out, input.model, request.overwrite)
                          : as_frames ? export_frames(request, input.model)
                                      : export_tessera(request, input.model);
  result["out"] = request.out, result["format"] = request.format;
  result["model"] = input.file.string(), result["num_gaussians"] = input.model.count();
  const int64_t frames = result["frames"], bytes = result["bytes"];
  print_result(request.json, result,
               fmt::format("{}: {} file{}, {:.1f} MB", request.out, frames, frames == 1 ? "" : "s",
                           double(bytes) / 1e6));
  return kExitDone;
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
  std::string formats =
      "\n    tessera     one 4D .ply"
      "\n    splatv      one .splatv in continuous time, no view-dependent colour; splaTV, "
      "gsplat.js";
  for (const SplatFormat& format : splat_formats())
    formats +=
        fmt::format("\n    {:<10}  numbered {}: {}", format.name, format.extension, format.doc);
  command->add_option("--format", request->format, "of the files:" + formats);
  CLI::Option* frames =
      command->add_option("--frames", request->frames, "moments, evenly from first to last");
  CLI::Option* fps =
      command->add_option("--fps", request->fps, "moments a second of the capture's clock");
  CLI::Option* time =
      command->add_option("--time", request->time, "a single moment, 0 (first) to 1 (last)");
  fps->excludes(frames), time->excludes(frames), time->excludes(fps);
  command->add_option("--spz-version", request->spz_version,
                      "of .spz: 3 (most players) or 4 (zstd; three.js, splat-transform)");
  command->add_flag("--keep-world", request->keep_world,
                    "stay in the world of the prepared scene; default: back in the capture's own");
  command->add_flag("--overwrite", request->overwrite, "write among files that are not ours");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return export_command(*request); }; });
}

}  // namespace tessera
