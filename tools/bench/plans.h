// The runs of a chart, a curve or a table, from the request.
#pragma once
#include "tools/bench/run.h"
#include "tools/bench/tables.h"
#include "tools/cli/train_arguments.h"

namespace tessera {

struct BenchPlan {
  std::vector<BenchRun> runs;
  std::vector<std::string> skipped;  // a line for each scene or row that is left out, with why
};

/// What all modes share. Options that are typed go over every preset, and under a row's own.
struct BenchAxes {
  TrainArguments training;
  std::vector<std::string> presets = {"fast", "balanced", "faster-gs"};
  std::vector<int64_t> seeds = {1};
};

/// Errors (all): InputError: options that do not fit each other or the scenes.
/// scene × preset × budget × seed; a budget is the steps of a training.
BenchPlan plan_chart(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                     const std::vector<int64_t>& budgets);
/// scene × preset × seed: one training each, as long as the last of `at`, scored at each of them.
BenchPlan plan_curve(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                     std::vector<int64_t> score_at);
/// scene × row × seed, but for rows with count_of.
BenchPlan plan_table(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                     const BenchTable& table);
/// The rows with count_of, by the `records` of those before; runs of rows that are not done yet
/// wait.
BenchPlan plan_counted_rows(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                            const BenchTable& table, const nlohmann::json& records);

/// scene × preset × seed, each with the steps of its preset or of the typed options.
BenchPlan plan_sizes(const BenchAxes& axes, const std::vector<BenchScene>& scenes);
/// scene × share × seed of the last preset, with max_gaussians the share of what the first preset's
/// run of that seed ended with, by the `records` of plan_sizes; runs whose count is not known yet
/// wait.
BenchPlan plan_budgets(const BenchAxes& axes, const std::vector<BenchScene>& scenes,
                       const std::vector<int64_t>& shares, const nlohmann::json& records);

}  // namespace tessera
