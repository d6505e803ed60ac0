// The driver of decisions during a training: it measures what Gaussians contribute, lets pure
// functions choose (motion_choice.h, pruning_choice.h), and has the trainer apply their edits.
// Source: docs/explanation/size.md.
#pragma once
#include <array>
#include <optional>

#include "recon4d/reduction/decision_schedule.h"
#include "recon4d/reduction/pruning_choice.h"
#include "recon4d/reduction/size_limit.h"
#include "recon4d/training/trainer.h"
#include "recon4d/training/validation.h"

namespace tessera {

/// What one decision did.
struct ReductionReport {
  int64_t iteration = 0, sampled_frames = 0;  // frames that its first pass drew
  int64_t static_before = 0, dynamic_before = 0, static_after = 0, dynamic_after = 0;
  int64_t knee = 0, goal = 0;  // Gaussians; goal 0: none at this step
  int64_t removed = 0, demoted = 0, promoted = 0, spawned = 0, spawned_missed = 0;
  double error_per_byte = 0;  // squared error per byte, the slope of the rate–distortion curve
  double demotion_error = 0;  // squared error that the demoted ones add
  double psnr = 0;            // dB, of the drawn frames before pruning,
  double psnr_after = 0;      // and after it
  std::array<int64_t, 4> degrees{};  // Gaussians by SH degree, where that was decided
  double seconds = 0;
};

nlohmann::json to_json(const ReductionReport& report);

class ModelReduction {
 public:
  /// `bytes` is called where options.max_bytes is given.
  ModelReduction(Backend& backend, const TrainOptions& options, ShippedBytes bytes);

  const DecisionSchedule& schedule() const { return schedule_; }
  /// Decides and changes the trainer's state where it has done a step at which that is due; once.
  std::optional<ReductionReport> act(Trainer& trainer, const ValidationRecord& validation);

 private:
  /// `known_goal`: of an earlier round, Gaussians; the bytes of the file are not measured here.
  SizeRequest size_request(const ValidationRecord& validation, int64_t known_goal,
                           int64_t rounds_left) const;

  Backend& backend_;
  const TrainOptions options_;
  DecisionSchedule schedule_;
  ShippedBytes bytes_;
};

}  // namespace tessera
