// What: loops over scenes, presets or rows, budgets and seeds, and the options of each.
// Not: any file.
#include "tools/bench/plans.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

/// A cell without its options' iterations and seed. Still scenes can only be trained as such.
BenchCell cell_of(const BenchAxes& axes, const BenchScene& scene, const std::string& preset,
                  const std::string& ablation) {
  TrainArguments arguments = axes.training;
  arguments.preset = preset;
  if (!ablation.empty()) arguments.ablation = ablation;
  BenchCell cell;
  cell.scene = scene;
  cell.label = cell.preset = preset;
  cell.ablation = arguments.ablation;
  cell.options = resolve_options(arguments, scene.facts);
  if (scene.facts.still) cell.options.static_only = true;
  return cell;
}

BenchCell with_steps(BenchCell cell, int64_t iterations, int64_t seed) {
  set_option(cell.options, "iterations", iterations);
  set_option(cell.options, "seed", seed);
  validate(cell.options);
  return cell;
}

void add(BenchPlan& plan, BenchCell cell) {
  cell.turn = int64_t(plan.cells.size());
  plan.cells.push_back(std::move(cell));
}

bool fits(SceneKind kind, const BenchScene& scene) {
  return kind == SceneKind::kAny || (kind == SceneKind::kStill) == scene.facts.still;
}

std::string misfit(const std::string& what, SceneKind kind, const BenchScene& scene) {
  return fmt::format("{}: {} is left out: it is of {} scenes, this one {}", scene.name, what,
                     kind == SceneKind::kStill ? "still" : "moving",
                     scene.facts.still ? "has one timestep" : "moves");
}

BenchCell row_cell(const BenchAxes& axes, const BenchScene& scene, const BenchTable& table,
                   const BenchRow& row) {
  BenchCell cell = cell_of(axes, scene, row_preset(row, scene.facts.still), row.ablation);
  for (const auto& [key, value] : row.overrides) set_option(cell.options, key, value);
  cell.label = row_label(row, scene.facts.still);
  cell.row = row.name;
  cell.scales = table.scales;
  return cell;
}

/// The record of another row of the same scene and seed.
const json* record_of(const json& records, const BenchCell& cell, const std::string& row) {
  for (const json& record : records)
    if (record.value("row", "") == row && record["scene"] == cell.scene.name &&
        record["seed"] == cell.options.seed && record["status"] == "done")
      return &record;
  return nullptr;
}

/// Which shard ran the row that this one counts by.
int64_t turn_of(const json& records, const BenchCell& cell, const std::string& row) {
  for (size_t i = 0; i < records.size(); ++i)
    if (records[i].value("row", "") == row && records[i]["scene"] == cell.scene.name &&
        records[i]["seed"] == cell.options.seed)
      return int64_t(i);
  return 0;
}

/// Its max_gaussians a share of what another row ended with, or what it waits for.
void limit_by(const json& records, const std::string& row, int64_t share, BenchCell& cell) {
  cell.turn = turn_of(records, cell, row);
  const json* const counted = record_of(records, cell, row);
  if (counted == nullptr) {
    cell.waits_for = fmt::format("waits for row {} of seed {}", row, cell.options.seed);
    return;
  }
  const int64_t count = counted->at("metrics").at("num_gaussians");
  set_option(cell.options, "max_gaussians", std::max<int64_t>(1, (count + share / 2) / share));
}

}  // namespace

BenchPlan plan_chart(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                     const std::vector<int64_t>& budgets) {
  BenchPlan plan;
  for (const BenchScene& scene : scenes)
    for (const std::string& preset : axes.presets) {
      const BenchCell cell = cell_of(axes, scene, preset, "");
      for (int64_t budget : budgets)
        for (int64_t seed : axes.seeds) add(plan, with_steps(cell, budget, seed));
    }
  return plan;
}

BenchPlan plan_curve(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                     std::vector<int64_t> at) {
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end()), at.end());
  BenchPlan plan;
  for (const BenchScene& scene : scenes)
    for (const std::string& preset : axes.presets) {
      BenchCell cell = cell_of(axes, scene, preset, "");
      cell.at = at;
      for (int64_t seed : axes.seeds) add(plan, with_steps(cell, at.back(), seed));
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
          const BenchCell cell = row_cell(axes, scene, table, row);
          add(plan, with_steps(cell, cell.options.iterations, seed));
        }
    }
  }
  if (plan.cells.empty())
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
        BenchCell cell = row_cell(axes, scene, table, row);
        cell = with_steps(cell, cell.options.iterations, seed);
        limit_by(records, row.count_of, 1, cell);
        plan.cells.push_back(std::move(cell));
      }
    }
  return plan;
}

BenchPlan plan_sizes(const BenchAxes& axes, const std::vector<BenchScene>& scenes) {
  BenchPlan plan;
  for (const BenchScene& scene : scenes)
    for (const std::string& preset : axes.presets) {
      BenchCell cell = cell_of(axes, scene, preset, "");
      cell.row = preset;
      for (int64_t seed : axes.seeds) add(plan, with_steps(cell, cell.options.iterations, seed));
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
        BenchCell cell = cell_of(axes, scene, axes.presets.back(), "");
        cell = with_steps(cell, cell.options.iterations, seed);
        cell.row = fmt::format("{}, 1/{} of {}", cell.preset, share, reference);
        cell.label += fmt::format("+one-in-{}-of-{}", share, reference);
        cell.share = share;
        limit_by(records, reference, share, cell);
        plan.cells.push_back(std::move(cell));
      }
  return plan;
}

}  // namespace tessera
