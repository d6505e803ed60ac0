// Loops over scenes, presets or rows, budgets and seeds, and sets the options of each run.
#include "tools/bench/plans.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "recon4d/options/presets.h"

namespace tessera {
namespace {

using nlohmann::json;

/// Sets an option, whatever the motion will be.
void set_in(BenchRun& run, const std::string& key, const OptionValue& value) {
  set_option(run.options, key, value);
  if (run.with_nodes) set_option(*run.with_nodes, key, value);
}

/// A run without its options' iterations and seed. Still scenes can only be trained as such.
BenchRun run_of(const BenchAxes& axes, const BenchScene& scene, const std::string& preset,
                const std::string& ablation) {
  TrainArguments arguments = axes.training;
  arguments.preset = preset;
  if (!ablation.empty()) arguments.ablation = ablation;
  BenchRun run;
  run.scene = scene;
  run.label = run.preset = preset;
  run.ablation = arguments.ablation;
  PlannedOptions planned = resolve_options(arguments, scene.facts);
  run.options = std::move(planned.options);
  run.with_nodes = std::move(planned.with_nodes);
  if (scene.facts.still) run.options.motion = Motion::kNone;
  return run;
}

BenchRun with_steps(BenchRun run, int64_t iterations, int64_t seed) {
  set_in(run, "iterations", iterations);
  set_in(run, "seed", seed);
  validate(run.options);
  return run;
}

void add(BenchPlan& plan, BenchRun run) {
  run.turn = int64_t(plan.runs.size());
  plan.runs.push_back(std::move(run));
}

bool fits(SceneKind kind, const BenchScene& scene) {
  return kind == SceneKind::kAny || (kind == SceneKind::kStill) == scene.facts.still;
}

std::string misfit(const std::string& what, SceneKind kind, const BenchScene& scene) {
  return fmt::format("{}: {} is left out: it is of {} scenes, this one {}", scene.name, what,
                     kind == SceneKind::kStill ? "still" : "moving",
                     scene.facts.still ? "has one timestep" : "moves");
}

BenchRun row_cell(const BenchAxes& axes, const BenchScene& scene, const BenchTable& table,
                  const BenchRow& row) {
  BenchRun run = run_of(axes, scene, row_preset(row, scene.facts.still), row.ablation);
  for (const auto& [key, value] : row.overrides) set_in(run, key, value);
  run.label = row_label(row, scene.facts.still);
  run.row = row.name;
  run.scales = table.scales;
  return run;
}

/// The record of another row of the same scene and seed.
const json* record_of(const json& records, const BenchRun& run, const std::string& row) {
  for (const json& record : records)
    if (record.value("row", "") == row && record["scene"] == run.scene.name &&
        record["seed"] == run.options.seed && record["status"] == "done")
      return &record;
  return nullptr;
}

/// Which shard ran the row that this one counts by.
int64_t turn_of(const json& records, const BenchRun& run, const std::string& row) {
  for (size_t i = 0; i < records.size(); ++i)
    if (records[i].value("row", "") == row && records[i]["scene"] == run.scene.name &&
        records[i]["seed"] == run.options.seed)
      return int64_t(i);
  return 0;
}

/// Its max_gaussians a share of what another row ended with, or what it waits for.
void limit_by(const json& records, const std::string& row, int64_t share, BenchRun& run) {
  run.turn = turn_of(records, run, row);
  const json* const counted = record_of(records, run, row);
  if (counted == nullptr) {
    run.waits_for = fmt::format("waits for row {} of seed {}", row, run.options.seed);
    return;
  }
  const int64_t count = counted->at("metrics").at("num_gaussians");
  set_in(run, "max_gaussians", std::max<int64_t>(1, (count + share / 2) / share));
}

}  // namespace

BenchPlan plan_chart(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                     const std::vector<int64_t>& budgets) {
  BenchPlan plan;
  for (const BenchScene& scene : scenes)
    for (const std::string& preset : axes.presets) {
      const BenchRun run = run_of(axes, scene, preset, "");
      for (int64_t budget : budgets)
        for (int64_t seed : axes.seeds) add(plan, with_steps(run, budget, seed));
    }
  return plan;
}

BenchPlan plan_curve(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                     std::vector<int64_t> score_at) {
  std::sort(score_at.begin(), score_at.end());
  score_at.erase(std::unique(score_at.begin(), score_at.end()), score_at.end());
  BenchPlan plan;
  for (const BenchScene& scene : scenes)
    for (const std::string& preset : axes.presets) {
      BenchRun run = run_of(axes, scene, preset, "");
      run.score_at = score_at;
      for (int64_t seed : axes.seeds) add(plan, with_steps(run, score_at.back(), seed));
    }
  return plan;
}

BenchPlan plan_table(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                     const BenchTable& table) {
  BenchPlan plan;
  for (const BenchScene& scene : scenes) {
    if (!fits(table.kind, scene)) {
      plan.skipped.push_back(misfit("table " + table.name, table.kind, scene));
      continue;
    }
    for (const BenchRow& row : table.rows) {
      if (!fits(row.kind, scene))
        plan.skipped.push_back(misfit("row " + row.name, row.kind, scene));
      else if (row.count_of.empty())
        for (int64_t seed : axes.seeds) {
          const BenchRun run = row_cell(axes, scene, table, row);
          add(plan, with_steps(run, run.options.iterations, seed));
        }
    }
  }
  if (plan.runs.empty())
    throw InputError(fmt::format("bench --table {}: nothing to run: {}", table.name,
                                 fmt::join(plan.skipped, "; ")));
  return plan;
}

BenchPlan plan_counted_rows(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                            const BenchTable& table, const json& records) {
  BenchPlan plan;
  for (const BenchScene& scene : scenes)
    for (const BenchRow& row : table.rows) {
      if (row.count_of.empty() || !fits(table.kind, scene) || !fits(row.kind, scene)) continue;
      for (int64_t seed : axes.seeds) {
        BenchRun run = row_cell(axes, scene, table, row);
        run = with_steps(run, run.options.iterations, seed);
        limit_by(records, row.count_of, 1, run);
        plan.runs.push_back(std::move(run));
      }
    }
  return plan;
}

BenchPlan plan_sizes(const BenchAxes& axes, const std::vector<BenchScene>& scenes) {
  BenchPlan plan;
  for (const BenchScene& scene : scenes)
    for (const std::string& preset : axes.presets) {
      BenchRun run = run_of(axes, scene, preset, "");
      run.row = preset;
      for (int64_t seed : axes.seeds) add(plan, with_steps(run, run.options.iterations, seed));
    }
  return plan;
}

BenchPlan plan_budgets(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                       const std::vector<int64_t>& shares, const json& records) {
  BenchPlan plan;
  const std::string& reference = axes.presets.front();
  for (const BenchScene& scene : scenes)
    for (int64_t share : shares)
      for (int64_t seed : axes.seeds) {
        BenchRun run = run_of(axes, scene, axes.presets.back(), "");
        run = with_steps(run, run.options.iterations, seed);
        run.row = fmt::format("{}, 1/{} of {}", run.preset, share, reference);
        run.label += fmt::format("+one-in-{}-of-{}", share, reference);
        run.share = share;
        limit_by(records, reference, share, run);
        plan.runs.push_back(std::move(run));
      }
  return plan;
}

}  // namespace tessera
