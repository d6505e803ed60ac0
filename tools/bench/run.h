// What: cells are trained, scored and timed, each in its folder; what is done is not done again.
// Not: which cells (bench/plans.h) or what becomes of their results (bench/report.h).
#pragma once
#include "tools/bench/cell.h"

namespace tessera {

struct BenchRunOptions {
  std::filesystem::path root;
  std::string backend = "auto";
  int64_t checkpoint_every = 0;
  int64_t shard = 0, shards = 1;  // cells with turn % shards = shard are run here
};

/// Runs the cells of this shard that are not done, in order; says how each went. A cell that fails
/// is recorded, and the others go on; one that was interrupted goes on from its checkpoint. Every
/// cell as recorded_cell gives it, with this call's errors. Errors: Interrupted.
nlohmann::json run_cells(const BenchRunOptions& options, const std::vector<BenchCell>& cells);

}  // namespace tessera
