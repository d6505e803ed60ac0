// What leaves a training session: scores of its models on held-out views, the model that is
// written, and what is reported of it.
#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "kernels/backend.h"
#include "recon4d/model/gaussian_set.h"
#include "recon4d/model/train_state.h"
#include "recon4d/reduction/size_limit.h"
#include "recon4d/training/trainer.h"
#include "recon4d/training/validation.h"
#include "tools/session/training_log.h"

namespace tessera {

/// The best model by validation, reduced to the size that the options ask for where `is_final`; in
/// the host's memory. Nothing: the trainer's last model as it is.
std::optional<GaussianModel> shipped_model(Trainer& trainer, const TrainOptions& options,
                                           const Validation& validation, Backend& backend,
                                           const ShippedBytes& shipped_bytes, bool is_final);

/// {seconds, iterations, total_iterations, num_gaussians, num_static, num_dynamic, validation (null
/// without validation views), exposure (null without learned gains)}; `shipped`: the model that is
/// written.
nlohmann::json training_result(const TrainState& state, const TrainOptions& options,
                               const Validation& validation, const GaussianModel& shipped);

/// What is scored, and what the scores are known by.
struct ScoredModel {
  const GaussianModel& model;
  int64_t step = 0;
  double seconds = 0;       // of training
  std::string event;        // of the log: "evaluation" or "shipped"
  bool is_complete = true;  // false: PSNR and SSIM alone
};

/// Whether the log has an evaluation after that step: one that was stopped is not in it.
bool was_scored(const std::filesystem::path& log, int64_t step);

class SessionScores {
 public:
  /// False where `stop`, asked after each view, ended the pass; then nothing is reported, and the
  /// scores stay those of before.
  bool score(Backend& backend, const Scene& scene, const ScoredModel& scored,
             const std::function<bool()>& stop, TrainingLog& log, SessionObserver& observer);
  /// As score_splits; an empty object before the first.
  const nlohmann::json& last() const { return last_; }

 private:
  nlohmann::json last_ = nlohmann::json::object();
};

}  // namespace tessera
