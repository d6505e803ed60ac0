// A training with its run folder: resolved options, log, checkpoints, model, evaluations. The run
// folder has config.json, log.jsonl, checkpoint.ckpt, model.ply, metrics.json; with validation
// also best_<step>.ply: the best model so far as it was, and model.ply then is that model.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "ingest/clocks/windows.h"
#include "ingest/scene.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options.h"
#include "recon4d/reduction/size_limit.h"
#include "tools/session/clock/time_limit.h"
#include "tools/session/session_observer.h"

namespace tessera {

struct TrainRequest {
  std::filesystem::path scene, run;
  TrainOptions options;
  std::optional<TrainOptions> with_nodes;  // PlannedOptions::with_nodes
  std::optional<Window> window;            // of the scene; nothing: all of it
  std::filesystem::path static_model;      // of static_model.h; empty: static Gaussians are trained
  std::string preset, ablation, backend = "auto";
  bool resume = false;
  int64_t evaluate_every = 0;               // of EvaluationPlan
  std::string made_for;                     // what the caller knows the training by; in config.json
  std::optional<int64_t> checkpoint_every;  // steps; without a value by the clock
  std::optional<int64_t> stop_after;        // steps of this call
  std::optional<int64_t> more_iterations;   // of a resumed training, in place of its own
  double time_limit = 0;                    // seconds by the stopwatch; 0: none
  ShippedBytes shipped_bytes;               // of a model of this run, as it is exported
  SnapshotSink* snapshots = nullptr;        // outlives the call; null: nobody wants any
  Stopwatch stopwatch = running_stopwatch();
};

/// Trains until the end, until the observer stops it, the time limit or stop_after; writes the run
/// folder, whose lock it holds meanwhile, and a reader's of the scene. Prints nothing. The object
/// has `left` (by the observer or the time limit: to be resumed), `seconds`, `iterations`,
/// `num_gaussians`, `peak_device_bytes`, `stage_ms`, `stage_gbytes`, `stage_gb_per_s`, `finished`,
/// `scores`, `bytes` (of model.ply), `wall_seconds` {load, init, train, evaluate, save},
/// `validation` (null without), …. Errors: InputError (among them: another training has the folder;
/// a time limit that leaves room for no step), CheckpointRefused (with `resume` alone), WriteError,
/// NumericalError.
nlohmann::json train_session(const TrainRequest& request, SessionObserver& observer);
/// The same. Where the checkpoint of a resumed training is refused, the folder is kept as RUN.1
/// with a warning, and the training starts anew.
nlohmann::json train_or_restart(TrainRequest request, SessionObserver& observer);

}  // namespace tessera
