// `tessera bench`: the options of its modes stages, chart, curve, table and sizes (bench/stages.h,
// bench/sweep.h).
#include <fmt/format.h>

#include <memory>

#include "kernels/base/errors.h"
#include "tools/bench/stages.h"
#include "tools/bench/sweep.h"
#include "tools/cli/argument_words.h"
#include "tools/cli/command.h"

namespace tessera {
namespace {

struct BenchRequest {
  StageBenchRequest stages;
  SweepRequest sweep;
  bool as_stages = false, as_chart = false, as_curve = false, as_sizes = false;
};

BenchMode mode_of(const BenchRequest& request) {
  const bool stages = request.as_stages || request.stages.ablations;
  const bool table = !request.sweep.table.empty();
  if (stages + request.as_chart + request.as_curve + request.as_sizes + table > 1)
    throw InputError(
        "bench: choose one of --stages (or --ablations), --chart, --curve, --table, --sizes");
  if (request.as_sizes) return BenchMode::kSizes;
  if (request.as_chart) return BenchMode::kChart;
  if (request.as_curve) return BenchMode::kCurve;
  return table ? BenchMode::kTable : BenchMode::kStages;
}

void refuse(const CLI::App& command, const char* option, const std::string& instead) {
  if (command.count(option) > 0)
    throw InputError(fmt::format("bench: {} has no meaning here; {}", option, instead));
}

/// Options that a single mode has.
void refuse_of_one_mode(const CLI::App& command, BenchMode mode) {
  if (mode != BenchMode::kChart) {
    refuse(command, "--budgets", "it goes with --chart");
    refuse(command, "--published", "it goes with --chart");
  }
  if (mode != BenchMode::kCurve) refuse(command, "--at", "it goes with --curve");
  if (mode != BenchMode::kSizes) refuse(command, "--shares", "it goes with --sizes");
}

/// What the other modes have is refused, not ignored.
void check_options(const CLI::App& command, const BenchRequest& request, BenchMode mode) {
  const SweepRequest& sweep = request.sweep;
  if (mode == BenchMode::kStages) {
    for (const char* option : {"--out", "--seeds", "--shard", "--plot"})
      refuse(command, option, "it goes with --chart, --curve, --table or --sizes");
    refuse(command, "--presets", "it goes with --chart, --curve or --sizes");
    refuse_of_one_mode(command, mode);
    if (sweep.scenes.size() != 1)
      throw InputError("bench: name one scene to time its stages, or pass --chart or --table NAME");
    return;
  }
  for (const char* option :
       {"--model", "--runs", "--gaussians", "--opacity", "--steps", "--warm-up"})
    refuse(command, option, "it goes with --stages");
  refuse(command, "--seed", "use --seeds");
  refuse(command, "--evaluate-every", "use --curve with --at");
  refuse(command, "--preset", mode == BenchMode::kTable ? "rows have theirs" : "use --presets");
  if (mode == BenchMode::kTable)
    for (const char* option : {"--presets", "--ablation"})
      refuse(command, option, "rows have theirs");
  refuse_of_one_mode(command, mode);
  if (mode == BenchMode::kSizes)
    refuse(command, "--max-gaussians", "the budgets are shares of the reference; use --shares");
  if (mode == BenchMode::kChart) refuse(command, "--iterations", "use --budgets");
  if (mode == BenchMode::kCurve) refuse(command, "--iterations", "use --at");
  if (sweep.out.empty()) throw InputError("bench: pass -o DIR for the runs and their results");
  if (sweep.scenes.empty() && !sweep.plot_only) throw InputError("bench: name a scene");
  refuse_repeats(sweep.axes.presets, "bench: --presets");
  refuse_repeats(sweep.axes.seeds, "bench: --seeds");
  refuse_repeats(sweep.budgets, "bench: --budgets");
  refuse_repeats(sweep.shares, "bench: --shares");
  for (int64_t share : sweep.shares)
    if (share < 1)
      throw InputError(fmt::format("bench: --shares has {}; pass 2 for a half", share));
  for (const std::vector<int64_t>* steps : {&sweep.budgets, &sweep.score_at})
    for (int64_t step : *steps)
      if (step < 1) throw InputError(fmt::format("bench: {} steps; pass at least 1", step));
}

int bench(const CLI::App& command, BenchRequest& request) {
  const BenchMode mode = mode_of(request);
  check_options(command, request, mode);
  if (mode == BenchMode::kStages) {
    request.stages.scene = request.sweep.scenes.front();
    return bench_stages_command(request.stages);
  }
  request.sweep.mode = mode;
  if (mode == BenchMode::kSizes && command.count("--presets") == 0)
    request.sweep.axes.presets = {"faster-gs", TrainArguments{}.preset};
  request.sweep.axes.training = request.stages.training;
  request.sweep.json = request.stages.json;
  return sweep(request.sweep);
}

void add_stage_options(CLI::App& command, BenchRequest& request) {
  StageBenchRequest& stages = request.stages;
  command.add_flag("--stages", request.as_stages,
                   "time and bytes of every stage of a step on a fixed load (the default)");
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

void add_sweep_options(CLI::App& command, BenchRequest& request) {
  SweepRequest& sweep = request.sweep;
  std::string tables;
  for (const BenchTable& table : bench_tables())
    tables += fmt::format("\n    {:<13} {}", table.name, table.doc);
  command.add_flag("--chart", request.as_chart,
                   "scenes x presets x budgets x seeds: quality against training time and size");
  command.add_flag("--curve", request.as_curve,
                   "quality against training time at fixed steps of one training a preset");
  command.add_flag("--sizes", request.as_sizes,
                   "quality against the bytes of the shipped file: a reference preset, others, and "
                   "the last of them with shares of the reference's Gaussians");
  command.add_option("--table", sweep.table,
                     "a table of the paper; rows go over the options that are typed:" + tables);
  command.add_option("-o,--out", sweep.out,
                     "folder of the runs and results; what is done there is not run again");
  command
      .add_option("--presets", sweep.axes.presets,
                  "of --chart and --curve; of --sizes the first is the reference, the last is "
                  "trained with its shares (default there: faster-gs,balanced)")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--budgets", sweep.budgets, "steps of the chart's trainings")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--at", sweep.score_at, "steps of the curve; the last ends the training")
      ->delimiter(',')
      ->capture_default_str();
  command
      .add_option("--shares", sweep.shares,
                  "of --sizes: 2,4 are a half and a quarter of what the reference ended with")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--seeds", sweep.axes.seeds, "a training each; the median is shown")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--published", sweep.published,
                     "JSON file of figures for the chart: name, scene, psnr, seconds, device");
  command.add_option("--shard", sweep.shard,
                     "i/n: only every n-th run from the i-th; several calls fill one folder");
  command.add_flag("--plot", sweep.plot_only,
                   "tables and images of what is done, without running anything");
}

}  // namespace

void add_bench_command(CLI::App& app, Work& work) {
  CLI::App* command = app.add_subcommand(
      "bench", "measure stage times, speed-accuracy charts, tables and time-to-quality curves");
  auto request = std::make_shared<BenchRequest>();
  command->add_option("scenes", request->sweep.scenes,
                      "prepared scenes or D-NeRF folders; PATH:val is scored on that split");
  add_stage_options(*command, *request);
  add_sweep_options(*command, *request);
  command->add_flag("--json", request->stages.json, "print one JSON object");
  add_train_options(*command, request->stages.training);
  command->callback([request, command, &work] {
    work = [request, command] { return bench(*command, *request); };
  });
}

}  // namespace tessera
