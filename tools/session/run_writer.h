// Writes a training into its run folder: config.json, log, checkpoints, best models, results.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/model/train_state.h"
#include "recon4d/training/validation.h"
#include "tools/session/run_folder.h"
#include "tools/session/training_log.h"

namespace tessera {

/// Errors of all members: WriteError. The caller has the run's lock.
class RunWriter {
 public:
  RunWriter(const std::filesystem::path& run, SessionObserver& observer)
      : folder_{run}, observer_(observer) {}

  const RunFolder& folder() const { return folder_; }

  /// To the observer and into the log, which begins after the first warnings.
  void warn(const std::string& warning);

  /// A run that was here goes when there is something to put in its place, not before: a scene that
  /// cannot be read or a full disk costs nothing. config.json comes last, so that a checkpoint
  /// beside it is one of its training.
  void replace_previous_run(const nlohmann::json& config);
  /// The best model that a checkpoint names. Errors: CheckpointRefused: it is gone.
  GaussianModel read_best(int64_t step);

  /// Of a training of `total` steps that begins after `first` of them; `start` is its event.
  TrainingLog& begin_log(int64_t total, int64_t first, nlohmann::json start);
  TrainingLog& log() { return *log_; }

  /// The best model before the checkpoint that names it; older ones after it.
  void write_checkpoint(const TrainState& state, const TrainOptions& options,
                        const nlohmann::json& config, const Validation& validation);
  void write_model(const GaussianModel& model);

 private:
  const RunFolder folder_;
  SessionObserver& observer_;
  std::optional<TrainingLog> log_;
  std::vector<std::string> early_warnings_;  // before there is a log
  int64_t best_ = 0;  // step of the best model whose file this session has written or read
};

}  // namespace tessera
