// `tessera bench --chart`, `--table`, `--curve` and `--sizes`: many trainings in one folder, and
// their results as JSON, CSV, Markdown and images. DIR holds runs/ (a folder a run), chart.json,
// chart.csv, chart_SCENE.svg; curve.* alike; table_NAME.json|csv|md; sizes.json|csv|md|svg.
#pragma once
#include "tools/bench/plans.h"

namespace tessera {

enum class BenchMode { kStages, kChart, kCurve, kTable, kSizes };

struct SweepRequest {
  BenchMode mode = BenchMode::kChart;
  std::vector<std::string> scenes;  // PATH or PATH:split
  std::filesystem::path out;
  BenchAxes axes;
  std::vector<int64_t> budgets = {1000, 3000, 7000, 15000};
  std::vector<int64_t> score_at = {500, 1000, 2000, 4000, 7000, 10000, 15000, 20000, 30000};
  std::vector<int64_t> shares = {2, 4, 8, 16};  // of the reference's Gaussians: 1/2, …
  std::string table;                            // name
  std::string shard;                            // "2/4": the second of four
  std::string published;                        // file
  bool plot_only = false, json = false;
};

/// Prints tables; returns an exit code: 1 when a run has failed. Errors: InputError, Interrupted.
int sweep(const SweepRequest& request);

}  // namespace tessera
