// What: no more than the scene needs, during a training: when Gaussians are pruned, become
//       static or dynamic, and how many are to be left.
// Not: a look at images (contributions.h), an order (pruning.h), nor the exact size in the end
//      (size_limit.h).
// Source: docs/explanation/size.md.
#pragma once
#include <array>
#include <functional>
#include <optional>

#include "recon4d/reduction/pruning.h"
#include "recon4d/reduction/size_limit.h"
#include "recon4d/training/trainer.h"
#include "recon4d/training/validation.h"

namespace tessera {

/// What one decision did.
struct ReductionReport {
  int64_t iteration = 0, sampled_frames = 0;  // drawn by its first pass
  int64_t static_before = 0, dynamic_before = 0, static_after = 0, dynamic_after = 0;
  int64_t knee = 0, goal = 0;  // Gaussians; goal 0: none at this step
  int64_t removed = 0, demoted = 0, promoted = 0, spawned = 0;
  double error_per_byte = 0;  // squared error per byte, the slope of the rate–distortion curve
  double demotion_error = 0;  // squared error that the stilled ones add
  double psnr = 0;            // dB, of the frames looked at: before thinning,
  double psnr_after = 0;      // and after it
  std::array<int64_t, 4> degrees{};  // Gaussians by SH degree, where that was decided
  double seconds = 0;
};

nlohmann::json to_json(const ReductionReport& report);

class ModelReduction {
 public:
  /// `bytes` is asked where options.max_bytes is given.
  ModelReduction(Backend& backend, const TrainOptions& options, ShippedBytes bytes);

  /// The next step after `iteration` before which something is decided; past the end: none.
  int64_t next_after(int64_t iteration) const;
  /// Decides and changes the trainer's state where it has done a step at which that is due; once.
  std::optional<ReductionReport> act(Trainer& trainer, const ValidationRecord& validation);
  /// Whether the last thinning has been done when a trainer has decided after so many steps; true
  /// where there is none.
  bool has_pruned(int64_t iteration) const;

 private:
  /// Rounds of thinning that are left at step i, with the one there; 0: none at this step.
  int64_t rounds_left(int64_t i) const;
  bool decides_motion(int64_t i) const;
  /// Returns what was found where it still holds, because nothing was changed.
  std::optional<Contributions> decide_motion(Trainer& trainer, const FrameSample& sample,
                                             ReductionReport& report);
  void decide_colour(Trainer& trainer, const Contributions& contributions, double error_per_byte,
                     ReductionReport& report);
  /// `contributions`: of the model as it is.
  void prune(Trainer& trainer, const FrameSample& sample, const ValidationRecord& validation,
             Contributions contributions, ReductionReport& report);
  /// Gaussians to be left at the end, with some to spare for the last cut.
  int64_t goal_of(Trainer& trainer, const std::vector<Removal>& order,
                  const Contributions& contributions, const ValidationRecord& validation,
                  int64_t knee) const;

  Backend& backend_;
  const TrainOptions options_;
  ShippedBytes bytes_;
  std::vector<int64_t> rounds_, motion_;  // steps, ascending
};

}  // namespace tessera
