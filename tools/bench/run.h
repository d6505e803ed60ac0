// A run of a benchmark: one training of one scene, its folder and its results. The folder
// DIR/runs/SCENE/LABEL/ITERATIONS/SEED is a run folder with a result.json; LABEL ends in +curve
// where the run is scored during the training.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/options/presets.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// A scene on the command line.
struct BenchScene {
  std::filesystem::path path;
  std::string name;         // the folder's
  std::string split;        // that is scored: "test", "val" or "train"
  SceneFacts facts;         // for presets
  std::string fingerprint;  // of the folder
};

/// Errors: InputError: two scenes of one name, which would share folders.
std::vector<BenchScene> open_bench_scenes(const std::vector<std::string>& texts);

struct BenchRun {
  BenchScene scene;
  std::string label;             // names row and folder: "balanced", "3dgs+filter_2d=true"
  std::string preset, ablation;  // for config.json
  TrainOptions options;          // all of them, with iterations and seed
  std::optional<TrainOptions> with_nodes{};  // PlannedOptions::with_nodes
  std::vector<int64_t> score_at;             // steps at which it is scored on the way
  std::vector<double> scales;  // factors of the training resolution that it is scored at too
  std::string waits_for;       // why it cannot be run yet; empty: it can
  std::string row;             // of a table; or empty
  int64_t share = 0;           // a budget: a Gaussian for so many of the reference's; 0: none
  int64_t turn = 0;            // which shard runs it
};

std::filesystem::path folder_of_run(const std::filesystem::path& root, const BenchRun& run);
/// Of all that its result depends on: options, scene, split, steps, scales, version.
std::string run_fingerprint(const BenchRun& run);
/// scene, scene_path, split, label, iterations, seed, fingerprint, folder (below root), status
/// "missing"; row, share and error (why it waits) where there are.
nlohmann::json describe_run(const BenchRun& run);

/// The run as describe_run gave it, with what its folder holds: status "done" and the scores,
/// "failed" and an `error`, or as it was when the folder's result.json is absent, damaged or of
/// another fingerprint.
nlohmann::json recorded_run(const std::filesystem::path& root, nlohmann::json described);

}  // namespace tessera
