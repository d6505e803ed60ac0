// Calls each check, converts its table to JSON, and adds the forecasts of memory and the advice
// about presets.
#include "tools/commands/doctor_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/checks/camera_table.h"
#include "ingest/checks/cloud_health.h"
#include "ingest/checks/coverage.h"
#include "ingest/checks/exposure.h"
#include "ingest/checks/feature_matches.h"
#include "ingest/checks/leakage.h"
#include "ingest/checks/orientation.h"
#include "ingest/checks/sharpness.h"
#include "ingest/checks/time_range.h"
#include "ingest/files/json_file.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/parallel.h"
#include "recon4d/options/forecast.h"
#include "recon4d/options/presets.h"
#include "tools/cli/terminal.h"
#include "tools/session/device_choice.h"
#include "tools/windows/windows_forecast.h"

namespace tessera {
namespace {

using nlohmann::json;

void add(const Findings& findings, DoctorReport& report) {
  report.findings.insert(report.findings.end(), findings.begin(), findings.end());
}

void add_poses_and_exposure(const Scene& sample, DoctorReport& report) {
  const MatchedStations matched = match_stations(sample);
  const PoseCheck poses = check_poses(matched);
  add(poses.findings, report);
  json table = json::array();
  for (const PoseResidual& camera : poses.cameras)
    table.push_back({{"camera", camera.camera},
                     {"residual_px", camera.residual},
                     {"pairs", camera.pairs},
                     {"matches", camera.matches},
                     {"features", camera.features}});
  report.tables["poses"] = std::move(table);
  const ExposureCheck exposure = check_exposure(matched);
  add(exposure.findings, report);
  put_gains(exposure.gains, report.cameras);
  table = json::array();
  for (const CameraGain& camera : exposure.gains)
    table.push_back({{"camera", camera.camera}, {"gain", camera.gain}, {"matches", camera.pairs}});
  report.tables["exposure"] = std::move(table);
}

void add_sharpness(const Scene& sample, DoctorReport& report) {
  const SharpnessCheck sharp = check_sharpness(sample);
  add(sharp.findings, report);
  json table = json::array();
  for (const CameraSharpness& camera : sharp.cameras)
    table.push_back({{"camera", camera.camera},
                     {"sharpness", camera.sharpness},
                     {"softest_frame", camera.softest},
                     {"softest_relative", camera.softest_relative}});
  report.tables["blur"] = std::move(table);
}

void add_coverage_and_cloud(const Scene& all, const Scene& sample, DoctorReport& report) {
  const CoverageCheck coverage = check_coverage(all);
  add(coverage.findings, report);
  json alone = json::object();
  for (size_t s = 0; s < coverage.name.size(); ++s) alone[coverage.name[s]] = coverage.alone[s];
  report.tables["coverage"] = {{"by", coverage.by_cloud ? "cloud" : "grid"},
                               {"seen_by_none", coverage.seen_by_none},
                               {"seen_by_one", coverage.seen_by_one},
                               {"alone", std::move(alone)}};
  const CloudHealth cloud = check_cloud(sample);
  add(cloud.findings, report);
  report.tables["cloud"] = {{"points", cloud.points},
                            {"not_finite", cloud.not_finite},
                            {"duplicates", cloud.duplicates},
                            {"far", cloud.far},
                            {"unseen", cloud.unseen},
                            {"seen_by_one", cloud.seen_by_one},
                            {"colour_ratio", cloud.colour_ratio}};
}

/// Of clips: a transforms file states times in a unit of its own.
bool times_are_seconds(const std::filesystem::path& folder) {
  if (!is_prepared_scene(folder)) return false;
  const json object = read_json(folder / "transforms.json").at("tessera");
  const std::string layout = string_at(object, "layout", folder.string());
  return layout == "videos" || layout == "n3dv" || layout == "sequences";
}

void add_times(const ThinnedScene& scene, const std::filesystem::path& folder,
               DoctorReport& report) {
  const SceneTimes times = check_times(scene.all, times_are_seconds(folder));
  add(times.findings, report);
  const double moving = dynamic_share(scene.sample);
  if (moving >= 0)
    add({{Severity::kInfo, "time", "", fmt::format("{:.1f} % of the pixels change", 100 * moving),
          ""}},
        report);
  json table = json::array();
  for (const CameraTimes& camera : times.cameras)
    table.push_back({{"camera", camera.camera},
                     {"frames", camera.frames},
                     {"first", camera.first},
                     {"last", camera.last},
                     {"missing", camera.missing}});
  report.tables["time"] = {{"timesteps", times.timesteps},
                           {"moments", times.timesteps},  // the key of versions before 0.3
                           {"duration", times.duration},
                           {"dynamic_share", moving},
                           {"cameras", std::move(table)}};
}

void add_orientation(const Scene& all, DoctorReport& report) {
  const OrientationCheck orientation = check_orientation(all);
  add(orientation.findings, report);
  put_rolls(orientation.cameras, report.cameras);
  json table = json::array();
  for (const CameraRoll& camera : orientation.cameras)
    table.push_back({{"camera", camera.camera},
                     {"turned_degrees", camera.known ? json(camera.degrees) : json()}});
  report.tables["turned"] = std::move(table);
}

/// Offsets that the preparation recorded, and how well it knew them.
void add_clocks(const Scene& all, const std::filesystem::path& folder, DoctorReport& report) {
  if (!is_prepared_scene(folder)) return;
  const json object = read_json(folder / "transforms.json").at("tessera");
  if (!object.contains("cameras")) return;
  json table = json::object();
  double largest = 0;
  std::vector<RecordedClock> clocks;
  for (const json& camera : object["cameras"]) {
    const std::string where = (folder / "transforms.json").string();
    const double offset = finite_number(camera, "time_offset", where).value_or(0);
    clocks.push_back({string_at(camera, "name", where),
                      string_at(camera, "time_offset_source", where), offset,
                      finite_number(camera, "time_offset_uncertainty", where).value_or(0)});
    table[clocks.back().camera] = offset;
    largest = std::max(largest, std::abs(offset));
  }
  add(check_clocks(all, clocks), report);
  if (table.size() > 1 && largest > 0)
    add({{Severity::kInfo, "sync", "",
          fmt::format("clocks were set by up to {:.4f} s when the scene was prepared", largest),
          ""}},
        report);
  report.tables["sync"] = std::move(table);
}

double gib(int64_t bytes) {
  return double(bytes) / double(int64_t{1} << 30);
}

void add_forecast(const Scene& all, const WindowWish& wish, DoctorReport& report) {
  ForecastLoad load = forecast_load(all);
  load.threads = thread_count();
  int64_t most_frames = 0;
  json table = json::object();
  const SceneFacts facts = facts_of(all);
  for (const Preset& preset : presets()) {
    TrainOptions options;
    apply_preset(options, preset.name, facts);
    const TrainForecast f = forecast_training(load, options);
    table[preset.name] = {
        {"iterations", options.iterations},     {"gaussians", f.gaussians},
        {"frame_bytes", f.frame_bytes},         {"device_frame_bytes", f.device_frame_bytes},
        {"parameter_bytes", f.parameter_bytes}, {"step_bytes", f.step_bytes},
        {"total_bytes", f.total_bytes},         {"host_bytes", f.host_bytes},
        {"device_bytes", f.device_bytes},       {"cpu_seconds", f.cpu_seconds},
        {"gpu_seconds", f.gpu_seconds}};
    most_frames = std::max(most_frames, f.frame_bytes);
    if (preset.name != "fast" && preset.name != "balanced") continue;
    add({{Severity::kInfo, "forecast", "",
          fmt::format("--preset {}: {:.2f} GiB on this CPU in about {}; with a GPU {:.2f} GiB, and "
                      "{:.2f} GiB of its own memory, in {} on an H200; {:.2f} GiB are frames and "
                      "masks (seconds within a factor of 3)",
                      preset.name, gib(f.total_bytes), clock_time(f.cpu_seconds), gib(f.host_bytes),
                      gib(f.device_bytes), clock_time(f.gpu_seconds), gib(f.frame_bytes)),
          ""}},
        report);
  }
  report.tables["forecast"] = std::move(table);
  const int64_t memory = machine_memory();
  const WindowsForecast windows = forecast_windows(wish, all, memory, thread_count());
  report.tables["windows"] = windows.table;
  if (!windows.line.empty())
    add({{windows.fits ? Severity::kInfo : Severity::kError, "forecast", "", windows.line, ""}},
        report);
  if (windows.windows <= 1 && windows.fits && most_frames > memory * 8 / 10)
    add({{Severity::kError, "forecast", "",
          fmt::format("the frames of all splits and their masks take {:.1f} GiB, this machine has "
                      "{:.1f}",
                      gib(most_frames), gib(memory)),
          "prepare with a smaller --scale or fewer --frames"}},
        report);
}

}  // namespace

void examine(const ThinnedScene& scene, const std::filesystem::path& folder, const WindowWish& wish,
             DoctorReport& report) {
  for (const std::string& warning : scene.all.warnings)
    add({{Severity::kWarning, "scene", "", warning, ""}}, report);
  add_poses_and_exposure(scene.sample, report);
  add_orientation(scene.all, report);
  add_sharpness(scene.sample, report);
  add_coverage_and_cloud(scene.all, scene.sample, report);
  add_times(scene, folder, report);
  add_clocks(scene.all, folder, report);
  const Leakage leakage = check_leakage(scene.all, scene.images);
  add(leakage.findings, report);
  report.tables["leakage"] = {{"training_manifest", leakage.training_manifest},
                              {"training_frames", leakage.training_frames},
                              {"held_out_frames", leakage.held_out_frames},
                              {"same_pictures", leakage.same_images},
                              {"same_views", leakage.same_views}};
  add_forecast(scene.all, wish, report);
}

}  // namespace tessera
