// `tessera bench SCENE`: time and bytes of every stage of a training step on a fixed load
// (recon4d/training/stage_bench.h), or one row for each named ablation on it.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "kernels/base/errors.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/presets.h"
#include "recon4d/training/stage_bench.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/command.h"
#include "tools/cli/terminal.h"
#include "tools/cli/train_arguments.h"
#include "tools/session/device_choice.h"
#include "tools/session/train_start.h"

namespace tessera {
namespace {

using nlohmann::json;

struct StageBenchRequest {
  std::string scene;
  TrainArguments training;
  StageBenchOptions bench;
  std::string model;
  bool ablations = false;
  int64_t runs = 3;
  bool json = false;
};

json to_json(const StageBenchReport& report, double copy_rate, const std::string& device) {
  json stages = json::object();
  for (size_t s = 0; s < kStages; ++s) {
    const StageTotals& stage = report.stages[s];
    if (stage.seconds <= 0) continue;
    stages[kStageNames[s]] = {{"ms", 1e3 * stage.seconds},
                              {"gbytes", 1e-9 * stage.bytes},
                              {"gb_per_s", 1e-9 * stage.bytes / stage.seconds},
                              {"floor_ms", 1e3 * stage.bytes / copy_rate}};
  }
  return {{"device", device},
          {"gaussians", report.gaussians},
          {"splats", report.splats},
          {"instances", report.instances},
          {"pixels", report.pixels},
          {"step_ms", 1e3 * report.step_seconds},
          {"copy_gb_per_s", 1e-9 * copy_rate},
          {"peak_device_bytes", report.peak_bytes},
          {"stages", stages}};
}

std::string table_text(const json& result) {
  std::string text = fmt::format(
      "{}: {} Gaussians, {} splats, {} instances, {} pixels; copy {:.0f} GB/s\n"
      "{:<17}{:>10}{:>10}{:>10}{:>10}\n",
      result["device"].get<std::string>(), result["gaussians"].dump(), result["splats"].dump(),
      result["instances"].dump(), result["pixels"].dump(), result["copy_gb_per_s"].get<double>(),
      "stage", "ms", "GB", "GB/s", "floor ms");
  for (const auto& [name, stage] : result["stages"].items())
    text += fmt::format("{:<17}{:>10.3f}{:>10.3f}{:>10.0f}{:>10.3f}\n", name,
                        stage["ms"].get<double>(), stage["gbytes"].get<double>(),
                        stage["gb_per_s"].get<double>(), stage["floor_ms"].get<double>());
  return text +
         fmt::format("{:<17}{:>10.3f}\n", "step, wall time", result["step_ms"].get<double>());
}

/// Median step and largest memory of a few runs, each on a backend of its own.
json bench_row(const StageBenchRequest& request, const Scene& scene, const TrainOptions& options,
               const std::string& name) {
  std::vector<double> steps;
  int64_t peak = 0;
  for (int64_t run = 0; run < std::max<int64_t>(1, request.runs); ++run) {
    const std::unique_ptr<Backend> backend = make_backend(request.training.backend);
    const StageBenchReport report = bench_stages(*backend, scene, options, request.bench);
    steps.push_back(1e3 * report.step_seconds);
    peak = std::max(peak, report.peak_bytes);
  }
  std::sort(steps.begin(), steps.end());
  say(fmt::format("{:<28}{:>9.3f} ms ({:.3f} to {:.3f}), {:>6} MiB", name, steps[steps.size() / 2],
                  steps.front(), steps.back(), peak >> 20));
  return {{"name", name},
          {"step_ms", steps[steps.size() / 2]},
          {"least_ms", steps.front()},
          {"most_ms", steps.back()},
          {"peak_device_bytes", peak}};
}

/// Every named ablation on the same load.
json bench_ablations(const StageBenchRequest& request, const Scene& scene,
                     const TrainOptions& base) {
  json rows = json::array();
  for (const Ablation& ablation : ablations()) {
    TrainOptions options = base;
    apply_ablation(options, ablation.name);
    rows.push_back(bench_row(request, scene, options, ablation.name));
  }
  return rows;
}

int bench_stages_command(StageBenchRequest request) {
  TrainOptions options = resolve_options(request.training, request.scene).options;
  Scene scene = load_training_scene(request.scene, options);
  std::optional<GaussianModel> model;
  if (!request.model.empty()) {
    model = load_model(request.model);
    request.bench.model = &*model;
  } else {
    std::vector<std::string> warnings;
    std::unique_ptr<Backend> searching;  // only where a cloud is missing
    const auto device = [&] {
      searching = choose_backend(request.training.backend).backend;
      return searching->pixel_search();
    };
    complete_cloud(scene, options, {}, device, warnings);
    for (const std::string& warning : warnings) warn(warning);
  }
  resolve_by_cloud(scene, options);
  if (request.ablations) {
    const json rows = bench_ablations(request, scene, options);
    print_result(request.json, {{"ablations", rows}}, "");
    return kExitDone;
  }
  const std::unique_ptr<Backend> backend = make_backend(request.training.backend);
  const StageBenchReport report = bench_stages(*backend, scene, options, request.bench);
  // after it, so that the peak is that of the steps
  const json result = to_json(report, copy_bytes_per_second(*backend), backend->name());
  print_result(request.json, result, table_text(result));
  return kExitDone;
}

void add_stage_options(CLI::App& command, StageBenchRequest& stages) {
  command.add_option("--model", stages.model,
                     "trained model (.ply) as the load, instead of the initial Gaussians");
  command.add_flag("--ablations", stages.ablations,
                   "a row for each named ablation: median step of --runs, and memory");
  command.add_option("--runs", stages.runs, "of each ablation")->capture_default_str();
  command.add_option("--gaussians", stages.bench.gaussians,
                     "copies of the initial Gaussians up to that many; 0: as they are");
  command.add_option("--opacity", stages.bench.opacity, "of all Gaussians")->capture_default_str();
  command.add_option("--steps", stages.bench.steps, "measured")->capture_default_str();
  command.add_option("--warm-up", stages.bench.warm_up, "steps before")->capture_default_str();
}

}  // namespace

void add_bench_command(CLI::App& app, Work& work) {
  CLI::App* command = app.add_subcommand("bench", "time the stages of a training step");
  auto request = std::make_shared<StageBenchRequest>();
  command->add_option("scene", request->scene, "prepared scene or D-NeRF folder")->required();
  add_stage_options(*command, *request);
  command->add_flag("--json", request->json, "print one JSON object");
  add_train_options(*command, request->training);
  command->callback(
      [request, &work] { work = [request] { return bench_stages_command(*request); }; });
}

}  // namespace tessera
