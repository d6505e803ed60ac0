// What: no more than the scene needs, during a training: when Gaussians are thinned out, become
//       static or dynamic, and how many are to be left.
// Not: a look at pictures (worth.h), an order (thinning.h), nor the exact size in the end
//      (size_contract.h).
// Source: docs/parsimony.md.
#pragma once
#include <array>
#include <functional>
#include <optional>

#include "recon4d/reduction/size_contract.h"
#include "recon4d/reduction/thinning.h"
#include "recon4d/training/trainer.h"
#include "recon4d/training/validation.h"

namespace tessera {

/// What one decision did.
struct ParsimonyReport {
  int64_t iteration = 0, looked_at = 0;  // frames
  int64_t static_before = 0, dynamic_before = 0, static_after = 0, dynamic_after = 0;
  int64_t knee = 0, goal = 0;  // Gaussians; goal 0: none at this step
  int64_t removed = 0, stilled = 0, woken = 0, born = 0;
  double price = 0;                  // squared error that a byte is worth
  double still_error = 0;            // squared error that the stilled ones add
  double psnr = 0;                   // dB, of the frames looked at: before thinning,
  double thinned = 0;                // and after it
  std::array<int64_t, 4> degrees{};  // Gaussians by SH degree, where that was decided
  double seconds = 0;
};

nlohmann::json to_json(const ParsimonyReport& report);

class Parsimony {
 public:
  /// `bytes` is asked where options.max_bytes is given.
  Parsimony(Backend& backend, const TrainOptions& options, ShippedBytes bytes);

  /// The next step after `iteration` before which something is decided; past the end: none.
  int64_t next_after(int64_t iteration) const;
  /// Decides and changes the trainer's state where it has done a step at which that is due; once.
  std::optional<ParsimonyReport> act(Trainer& trainer, const ValidationRecord& validation);
  /// Whether the last thinning has been done when a trainer has decided after so many steps; true
  /// where there is none.
  bool is_thinned(int64_t iteration) const;

 private:
  /// Rounds of thinning that are left at step i, with the one there; 0: none at this step.
  int64_t rounds_left(int64_t i) const;
  bool decides_motion(int64_t i) const;
  /// Returns what was found where it still holds, because nothing was changed.
  std::optional<Worth> decide_motion(Trainer& trainer, const LookedAt& at, ParsimonyReport& report);
  void decide_colour(Trainer& trainer, const Worth& worth, double price, ParsimonyReport& report);
  /// `worth`: of the model as it is.
  void thin(Trainer& trainer, const LookedAt& at, const ValidationRecord& validation, Worth worth,
            ParsimonyReport& report);
  /// Gaussians to be left at the end, with some to spare for the last cut.
  int64_t goal_of(const GaussianModel& model, const std::vector<Removal>& order, const Worth& worth,
                  const ValidationRecord& validation, int64_t knee) const;

  Backend& backend_;
  const TrainOptions options_;
  ShippedBytes bytes_;
  std::vector<int64_t> rounds_, motion_;  // steps, ascending
};

}  // namespace tessera
