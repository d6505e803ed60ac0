// `tessera bench`: the options of the times of a training step's stages (bench/stages.h).
#include <memory>

#include "tools/bench/stages.h"
#include "tools/cli/command.h"

namespace tessera {
namespace {

void add_stage_options(CLI::App& command, StageBenchRequest& stages) {
  command.add_flag("--stages")
      ->description("time and bytes of every stage of a step on a fixed load (the default)");
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
