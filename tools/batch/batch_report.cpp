// Collects metrics.json, train.json and config.json of every run; bench/report.h computes medians
// and Pareto fronts.
#include "tools/batch/batch_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tools/bench/report.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void copy_number(const json& from, const char* key, json& to) {
  if (from.is_object() && from.contains(key) && from[key].is_number()) to[key] = from[key];
}

/// Where the workflow puts what it exports of a run, below OUT: FORMAT/ and, when that is done, its
/// record FORMAT.json.
fs::path exports_of(const BatchRun& run) {
  return fs::path("exports") / run.scene / run.preset / fmt::format("seed-{}", run.seed);
}

/// The player's page of a run, below OUT; "" where none was exported.
std::string player_of(const BatchFolder& batch, const BatchRun& run) {
  const fs::path exports = exports_of(run);
  for (const std::string format : {"html", "page"})
    if (const fs::path page = exports / format / "index.html";
        fs::exists(batch.root / page) &&
        fs::exists(batch.root / exports / (format + ".json")))  // of this model
      return page.string();
  return "";
}

/// Everything that is known of one run.
json describe_run(const BatchFolder& batch, const BatchRun& run, std::vector<std::string>& notes) {
  const json metrics = read_object(run.folder / "metrics.json", notes);
  const json trained = read_object(run.folder / "train.json", notes);
  const json config = read_object(run.folder / "config.json", notes);
  json entry = {{"scene", run.scene},
                {"preset", run.preset},
                {"seed", run.seed},
                {"state", name_of(run.state)},
                {"folder", run.folder.lexically_relative(batch.root).string()},
                {"player", player_of(batch, run)}};
  if (!run.error.empty()) entry["error"] = run.error;
  for (const char* key : {"psnr", "ssim", "num_gaussians", "num_static", "num_dynamic", "bytes"})
    copy_number(metrics, key, entry);
  for (const char* key : {"seconds", "iterations", "peak_device_bytes"})
    copy_number(trained, key, entry);
  if (metrics.is_object() && metrics.contains("split") && metrics["split"].is_string())
    entry["split"] = metrics["split"];
  const json file = read_object(batch.root / exports_of(run) / "tessera.json", notes);
  if (file.is_object() && file.contains("bytes")) entry["shipped_bytes"] = file["bytes"];
  if (config.is_object())
    for (const auto& [from, to] : {std::pair{"tessera", "version"}, {"device", "device"}})
      if (config.contains(from) && config[from].is_string()) entry[to] = config[from];
  return entry;
}

/// As bench_points takes it. Of one scene and preset all have the same label.
json bench_run_of(const json& run) {
  // what is done has scores, unless its file is damaged
  const std::string state = run["state"] == "done" ? "missing" : run["state"];
  json bench_run = {{"scene", run["scene"]},  {"split", run.value("split", "")},
                    {"label", run["preset"]}, {"iterations", run.value("iterations", int64_t{0})},
                    {"seed", run["seed"]},    {"status", run.contains("psnr") ? "done" : state}};
  if (run.contains("device")) bench_run["device"] = run["device"];
  if (run.contains("error")) bench_run["error"] = run["error"];
  for (const char* key : {"psnr", "ssim", "seconds", "num_gaussians", "num_static", "num_dynamic",
                          "bytes", "shipped_bytes", "peak_device_bytes"})
    copy_number(run, key, bench_run["metrics"]);
  return bench_run;
}

/// Seeds of one scene and preset are one point, also where one of them has nothing to show or was
/// stopped at another step.
json bench_runs_of(const json& runs) {
  json bench_runs = json::array();
  for (const json& run : runs) bench_runs.push_back(bench_run_of(run));
  for (json& bench_run : bench_runs)
    for (const json& other : bench_runs) {
      if (other["status"] != "done" || other["scene"] != bench_run["scene"]) continue;
      if (bench_run["split"] == "") bench_run["split"] = other["split"];
      if (other["label"] != bench_run["label"]) continue;
      bench_run["iterations"] = other["iterations"];
      break;
    }
  return bench_runs;
}

json failures_json(const BatchFolder& batch) {
  json failures = json::array();
  for (const BatchFailure& failure : batch.failures)
    failures.push_back({{"scene", failure.scene},
                        {"rule", failure.rule},
                        {"preset", failure.preset},
                        {"seed", failure.seed},
                        {"format", failure.format},
                        {"exit", failure.exit ? json(*failure.exit) : json()},
                        {"message", failure.message},
                        {"log", failure.log},
                        {"line", failure.line()}});
  return failures;
}

}  // namespace

json batch_report(const BatchFolder& batch) {
  std::vector<std::string> notes = batch.notes;
  json runs = json::array();
  std::set<std::string> versions, devices;
  for (const BatchRun& run : batch.runs) {
    runs.push_back(describe_run(batch, run, notes));
    if (runs.back().contains("version")) versions.insert(std::string(runs.back()["version"]));
    if (runs.back().contains("device")) devices.insert(std::string(runs.back()["device"]));
  }
  json earlier = json::array();
  for (const BatchRun& run : batch.earlier) earlier.push_back(describe_run(batch, run, notes));
  json scenes = bench_points(bench_runs_of(runs));
  mark_pareto_front(scenes);
  return {{"title", fs::absolute(batch.root).lexically_normal().string()},
          {"summary", batch_summary(batch)},
          {"counts",
           {{"runs", batch.runs.size()},
            {"done", batch.count(RunState::kDone)},
            {"failed", batch.count(RunState::kFailed)},
            {"missing", batch.count(RunState::kMissing)},
            {"scenes", batch.scenes().size()},
            {"whole_scenes", batch.whole_scenes()}}},
          {"versions", versions},
          {"devices", devices},
          {"variants", batch.asked.value("variants", json::array())},
          {"captures", batch.asked.value("scenes", json::array())},
          {"scenes", scenes},
          {"runs", runs},
          {"earlier_runs", earlier},
          {"failures", failures_json(batch)},
          {"notes", notes}};
}

}  // namespace tessera
