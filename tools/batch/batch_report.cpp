// Every run is reported as a run alone is (tools/report/run_report.h); points.h has the medians.
#include "tools/batch/batch_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/atomic_file.h"
#include "tools/batch/points.h"
#include "tools/jobs/job.h"
#include "tools/report/log_events.h"
#include "tools/report/run_report.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Where the workflow puts what it exports of a run, below OUT: FORMAT/ and, when that is done, its
/// record FORMAT.json.
fs::path exports_of(const BatchRun& run) {
  return fs::path("exports") / run.scene / run.preset / fmt::format("seed-{}", run.seed);
}

/// Records of the jobs of one run; null where there is none.
struct JobRecords {
  json ingest, trained, metrics, page, file;
  fs::path player;  // below OUT
};

/// Seconds that a job took; nothing where they are not known.
std::optional<double> seconds_of(const BatchFolder& batch, const std::string& job) {
  const json record = read_record({batch.root, {}}, job);
  return record.value("done", false) ? number_at(record, "seconds") : std::nullopt;
}

/// The jobs as `tessera run` records its stages. Where the seconds of one are not known, none are:
/// a sum without them would be wrong.
json ledger_of(const BatchFolder& batch, const BatchRun& run, const JobRecords& jobs) {
  json ledger = {{"ingest", {{"result", jobs.ingest}}}};
  const std::string place = fmt::format("{}/{}/seed-{}", run.scene, run.preset, run.seed);
  const auto ingest = seconds_of(batch, "ingest/" + run.scene),
             train = seconds_of(batch, "train/" + place),
             evaluate = seconds_of(batch, "evaluate/" + place);
  if (!ingest || !train || !evaluate) return ledger;
  ledger["ingest"]["seconds"] = *ingest;
  ledger["train"]["seconds"] = *train;
  ledger["evaluate"]["seconds"] = *evaluate;
  double exported = 0;
  for (const json& format : batch.asked.value("exports", json::array()))
    if (format.is_string())
      exported += seconds_of(batch, fmt::format("export/{}/{}", place, format.get<std::string>()))
                      .value_or(0);
  if (exported > 0) ledger["export"]["seconds"] = exported;
  return ledger;
}

class RunReader {
 public:
  RunReader(const BatchFolder& batch, std::vector<std::string>& notes)
      : batch_(batch), notes_(notes) {}

  /// As `runs` of report.json has it.
  json report_of(const BatchRun& run) {
    JobRecords jobs;
    jobs.ingest = record(fs::path("scenes") / (run.scene + ".json"));
    const fs::path folder = run.folder.lexically_relative(batch_.root);
    if (run.has_other_result) {
      json report = run_report({});
      add_batch(run, folder, jobs, report);
      report["files"] = json::array();
      return report;
    }
    jobs.trained = record(folder / "train.json");
    jobs.metrics = record(folder / "metrics.json");
    const fs::path exports = exports_of(run);
    for (const char* format : {"page", "html"})
      if (json page = record(exports / (std::string(format) + ".json")); !page.is_null())
        jobs.page = std::move(page), jobs.player = exports / format / "index.html";
    jobs.file = record(exports / "tessera.json");
    RunRecords records = read_records(run.folder);
    if (records.windows.empty()) records.config = record(folder / "config.json");
    records.metrics = jobs.metrics;
    records.stages = ledger_of(batch_, run, jobs);
    records.trained = jobs.trained;
    json report = run_report(records);
    if (!records.stages.contains("train")) report["seconds"]["command"] = nullptr;
    if (const auto seconds = number_at(jobs.trained, "seconds"))
      report["seconds"]["training"] = *seconds;
    add_batch(run, folder, jobs, report);
    return report;
  }

 private:
  /// Null where there is none.
  json record(const fs::path& file) {
    std::vector<std::string> notes;
    json found = read_object(batch_.root / file, notes);
    for (std::string& note : notes)  // that of a scene is read for each of its runs
      if (std::find(notes_.begin(), notes_.end(), note) == notes_.end())
        notes_.push_back(std::move(note));
    return found;
  }

  void add_batch(const BatchRun& run, const fs::path& folder, const JobRecords& jobs,
                 json& report) {
    report["id"] = fmt::format("{}/{}/seed-{}", run.scene, run.preset, run.seed);
    report["title"] = fmt::format("{}, seed {}", run.preset, run.seed);
    report["scene"] = run.scene;
    report["variant"] = run.preset;
    report["seed"] = run.seed;
    report["state"] = name_of(run.state);
    report["error"] = run.error.empty() ? json() : json(run.error);
    report["folder"] = folder.generic_string();
    report["image_note"] = nullptr;
    if (!report.contains("windows"))  // which have a model each
      report["size"]["model_bytes"] = or_null(number_at(jobs.metrics, "bytes"));
    report["size"]["shipped_bytes"] = or_null(number_at(jobs.file, "bytes"));
    report["size"]["player_bytes"] = or_null(number_at(jobs.page, "bytes"));
    if (const auto peak = number_at(jobs.trained, "peak_device_bytes"))
      report["size"]["peak_bytes"] = *peak;
    json& files = report["files"] = json::array();
    const auto add = [&](const char* name, const fs::path& file) {
      if (!file.empty() && fs::is_regular_file(batch_.root / file))
        files.push_back({{"name", name},
                         {"path", (fs::path("..") / file).generic_string()},
                         {"bytes", fs::file_size(batch_.root / file)}});
    };
    add("Player", jobs.player);
    add("Model", folder / "model.ply");
    add("Scores", folder / "metrics.json");
    add("Log", folder / "log.jsonl");
  }

  const BatchFolder& batch_;
  std::vector<std::string>& notes_;
};

/// As points_of takes it. Of one scene and variant all have the same label.
json point_run_of(const json& run) {
  const bool scored = !run["scores"]["psnr"].is_null();
  // what is done has scores, unless its file is damaged
  const json state = run["state"] == "done" ? json("missing") : run["state"];
  json one = {{"scene", run["scene"]},   {"split", run["split"]},
              {"label", run["variant"]}, {"iterations", run["steps"]},
              {"seed", run["seed"]},     {"status", scored ? json("done") : state}};
  if (run["device"] != "") one["device"] = run["device"];
  if (!run["error"].is_null()) one["error"] = run["error"];
  json& metrics = one["metrics"] = run["scores"];
  const json &size = run["size"], &seconds = run["seconds"];
  metrics.update({{"seconds", seconds["training"]},
                  {"command_seconds", seconds["command"]},
                  {"num_static", size["static"]},
                  {"num_dynamic", size["dynamic"]},
                  {"num_gaussians", count_at(size, "static") + count_at(size, "dynamic")},
                  {"bytes", size["model_bytes"]},
                  {"shipped_bytes", size["shipped_bytes"]},
                  {"peak_device_bytes", size["peak_bytes"]}});
  return one;
}

/// Seeds of one scene and variant are one point, also where one of them has nothing to show or was
/// stopped at another step.
json point_runs_of(const json& runs) {
  json point_runs = json::array();
  for (const json& run : runs) point_runs.push_back(point_run_of(run));
  for (json& point_run : point_runs)
    for (const json& other : point_runs) {
      if (other["status"] != "done" || other["scene"] != point_run["scene"]) continue;
      if (point_run["split"] == "") point_run["split"] = other["split"];
      if (other["label"] != point_run["label"]) continue;
      point_run["iterations"] = other["iterations"];
      break;
    }
  return point_runs;
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
                        {"log", failure.log.empty() ? "" : "../" + failure.log},
                        {"line", failure.line()}});
  return failures;
}

json counts_of(const BatchFolder& batch) {
  return {{"runs", batch.runs.size()},
          {"done", batch.count(RunState::kDone)},
          {"failed", batch.count(RunState::kFailed)},
          {"missing", batch.count(RunState::kMissing)},
          {"scenes", batch.scenes().size()},
          {"whole_scenes", batch.whole_scenes()}};
}

/// Versions or devices, each once.
json each_of(const json& runs, const char* key) {
  std::set<std::string> texts;
  for (const json& run : runs)
    if (run[key] != "") texts.insert(run[key].get<std::string>());
  return texts;
}

}  // namespace

json batch_report(const BatchFolder& batch) {
  std::vector<std::string> notes = batch.notes;
  RunReader reader(batch, notes);
  json runs = json::array(), earlier = json::array();
  for (const BatchRun& run : batch.runs) runs.push_back(reader.report_of(run));
  for (const BatchRun& run : batch.earlier) earlier.push_back(reader.report_of(run));
  const json scenes = points_of(point_runs_of(runs));
  const fs::path folder = fs::absolute(batch.root / "").lexically_normal().parent_path();
  const json common = {{"folder", folder.string()},
                       {"summary", batch_summary(batch)},
                       {"counts", counts_of(batch)},
                       {"versions", each_of(runs, "version")},
                       {"devices", each_of(runs, "device")},
                       {"variants", batch.asked.value("variants", json::array())},
                       {"captures", batch.asked.value("scenes", json::array())},
                       {"scenes", scenes},
                       {"earlier", earlier},
                       {"failures", failures_json(batch)},
                       {"notes", notes}};
  return {
      {"kind", "batch"}, {"title", folder.filename().string()}, {"runs", runs}, {"batch", common}};
}

}  // namespace tessera
