// Calls train_session, then loads, scores and times the model that it wrote.
#include "tools/bench/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "kernels/base/seconds_since.h"
#include "recon4d/evaluation/evaluate.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/train_options_json.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/cli/training_terminal.h"
#include "tools/export/formats.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"
#include "tools/session/train_session.h"
#include "tools/session/train_start.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

Split split_of(const std::string& name) {
  for (Split split : {Split::kTest, Split::kVal})
    if (name == name_of(split)) return split;
  return Split::kTrain;
}

TrainRequest request_of(const BenchRunOptions& options, const BenchRun& run,
                        const RunFolder& folder) {
  TrainRequest request;
  request.scene = run.scene.path;
  request.run = folder.root;
  request.options = run.options;
  request.with_nodes = run.with_nodes;
  request.preset = run.preset;
  request.ablation = run.ablation;
  request.backend = options.backend;
  request.checkpoint_every = options.checkpoint_every;
  request.evaluate_at = run.score_at;
  request.evaluate_end = false;
  request.overwrite = true;
  request.made_for = run_fingerprint(run);
  request.resume = can_resume(request, folder);
  request.shipped_bytes = shipped_bytes_of(folder.root.string());
  return request;
}

/// Scores on the way from log.jsonl; of a step that was taken twice, the later.
json scores_on_the_way(const RunFolder& folder, const BenchRun& run) {
  std::map<int64_t, json> by_step;
  std::istringstream lines(read_text_file(folder.log()));
  for (std::string line; std::getline(lines, line);) {
    const json event = json::parse(line, nullptr, false);
    if (!event.is_object() || event.value("event", "") != "evaluation") continue;
    const int64_t step = event.at("iteration");
    if (std::find(run.score_at.begin(), run.score_at.end(), step) == run.score_at.end()) continue;
    const json& scores = event.at("splits").at(run.scene.split);
    by_step[step] = {{"iteration", step},
                     {"seconds", event.at("seconds")},
                     {"num_gaussians", event.at("num_gaussians")},
                     {"psnr", scores.at("psnr")},
                     {"ssim", scores.at("ssim")}};
  }
  json curve = json::array();
  for (const auto& [step, scores] : by_step) curve.push_back(scores);
  return curve;
}

/// The model against images of other sizes: those that a training at this scale would have
/// loaded.
void score_at_scales(Backend& backend, const GaussianModel& model, const BenchRun& run,
                     json& metrics) {
  for (double scale : run.scales) {
    TrainOptions options = run.options;
    const double trained = to_json(options).at("train_scale");
    set_option(options, "train_scale", scale * trained);
    const Scene scene = load_training_scene(run.scene.path, options);
    const json scores = score_splits(backend, model, scene, {split_of(run.scene.split)},
                                     std::nullopt, {}, brief_scores());
    for (const char* key : {"psnr", "ssim"})
      metrics[fmt::format("{}_{}x", key, scale)] = scores.at(key);
  }
}

/// Scores and frames per second of the run's model, into `metrics` and the run's metrics.json.
void score(const BenchRunOptions& options, const BenchRun& run, const RunFolder& folder,
           json& result) {
  const GaussianModel model = load_model(folder.model());
  const Scene scene = load_training_scene(run.scene.path, run.options);
  const Split split = split_of(run.scene.split);
  const std::unique_ptr<Backend> backend = make_backend(options.backend);
  const Clock::time_point begin = Clock::now();
  const json scores = score_splits(
      *backend, model, scene, {split}, int64_t(fs::file_size(folder.model())),
      [](const Frame&, const RenderedImage&, const ViewScore&, int64_t, int64_t) {
        stop_if_interrupted();
      },
      brief_scores());
  json& metrics = result["metrics"];
  metrics["evaluate_seconds"] = seconds_since(begin);
  for (const char* key :
       {"psnr", "ssim", "psnr_float", "bytes", "num_gaussians", "num_static", "num_dynamic"})
    metrics[key] = scores.at(key);
  metrics["shipped_bytes"] = shipped_bytes(folder.root.string(), model);
  for (const char* key : {"width", "height", "views"}) result[key] = scores.at(key);
  std::vector<View> views;
  for (int i : scene.split_indices(split))
    views.push_back({scene.frames[size_t(i)].camera, scene.frames[size_t(i)].time});
  metrics["fps"] = measure_render_rate(*backend, model, views, {300, 3, 30}).fps();
  score_at_scales(*backend, model, run, metrics);
  write_text_file(folder.metrics(), scores.dump(2));
}

json complete_run(const BenchRunOptions& options, const BenchRun& run) {
  const RunFolder folder{folder_of_run(options.root, run)};
  const fs::path result_file = folder.root / "result.json";
  const SceneLock in_use(run.scene.path, SceneLock::Use::kRead);
  make_folder(folder.root);
  fs::remove(result_file);
  const TrainRequest request = request_of(options, run, folder);
  const Clock::time_point begin = Clock::now();
  TrainingTerminal terminal;
  const json trained = train_or_restart(request, terminal);
  const double wall = seconds_since(begin);
  stop_if_interrupted();
  json result = describe_run(run);
  result["options"] = to_json(run.options);
  result["device"] = trained.at("device");
  json& metrics = result["metrics"];
  metrics["seconds"] = trained.at("seconds");
  // the host's peak is that of all runs of this call
  if (!result["device"].get<std::string>().starts_with("cpu"))
    metrics["peak_device_bytes"] = trained.at("peak_device_bytes");
  // of a training in one go: what is neither a step nor a score on the way
  if (!request.resume && run.score_at.empty())
    metrics["load_seconds"] = wall - trained.at("seconds").get<double>();
  score(options, run, folder, result);
  if (!run.score_at.empty()) result["curve"] = scores_on_the_way(folder, run);
  result["status"] = "done";
  write_text_file(result_file, result.dump(2));
  fs::remove(
      folder.checkpoint());  // several times as large as the model, and nothing is left to do
  return result;
}

/// As complete_run; a failure becomes a record.
json run_or_record(const BenchRunOptions& options, const BenchRun& run) {
  json record = describe_run(run);
  try {
    return complete_run(options, run);
  } catch (const Interrupted&) {
    throw;
  } catch (const WriteError&) {
    throw;  // the next run would fail as well, and its record
  } catch (const std::bad_alloc&) {
    record["error"] = "out of memory";
  } catch (const std::exception& error) {
    record["error"] = error.what();
  }
  record["status"] = "failed";
  try {
    write_text_file(folder_of_run(options.root, run) / "result.json", record.dump(2));
  } catch (const std::exception& error) {
    warn(error.what());  // the record is in the report, too
  }
  return record;
}

std::string outcome(const json& record) {
  if (record["status"] != "done")
    return fmt::format("{}: {}", record["status"].get<std::string>(),
                       record.value("error", "not run yet"));
  const json& psnr = record["metrics"]["psnr"];  // null: infinite
  return fmt::format("{} dB after {:.1f} s of training",
                     psnr.is_number() ? fmt::format("{:.2f}", psnr.get<double>()) : "n/a",
                     record["metrics"]["seconds"].get<double>());
}

}  // namespace

json complete_runs(const BenchRunOptions& options, const std::vector<BenchRun>& runs) {
  json records = json::array();
  for (size_t i = 0; i < runs.size(); ++i) {
    const BenchRun& run = runs[i];
    const std::string name =
        fmt::format("run {} of {}: {} {}, {} steps, seed {}", i + 1, runs.size(), run.scene.name,
                    run.label, run.options.iterations, run.options.seed);
    json record = recorded_run(options.root, describe_run(run));
    const bool is_of_shard = run.turn % options.shards == options.shard && run.waits_for.empty();
    if (record["status"] == "done") {
      say(fmt::format("{}: done before, {}", name, outcome(record)));
    } else if (is_of_shard) {
      say(fmt::format("{}: begins", name));
      record = run_or_record(options, run);
      if (!run.row.empty()) record["row"] = run.row;
      say(fmt::format("{}: {}", name, outcome(record)));
    }
    records.push_back(std::move(record));
  }
  for (json& record : records)  // other shards may have come further meanwhile
    if (record["status"] == "missing") record = recorded_run(options.root, record);
  return records;
}

}  // namespace tessera
