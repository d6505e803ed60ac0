// Trains, scores and times runs, each in its folder; a finished run is not repeated.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "tools/bench/run.h"

namespace tessera {

struct BenchRunOptions {
  std::filesystem::path root;
  std::string backend = "auto";
  std::optional<int64_t> checkpoint_every = 0;
  int64_t shard = 0, shards = 1;  // runs with turn % shards = shard are run here
};

/// Runs the runs of this shard that are not done, in order, and prints how each ended. A run that
/// fails is recorded, and the others continue; one that was interrupted resumes from its
/// checkpoint. Every run as recorded_run gives it, with this call's errors. Errors: Interrupted.
nlohmann::json complete_runs(const BenchRunOptions& options, const std::vector<BenchRun>& runs);

}  // namespace tessera
