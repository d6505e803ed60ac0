// Validation frames, taken from the training split, and what follows from their scores: the best
// model so far and the end of the training. The pixels of the test split are not read. Source:
// failure modes A10, D4.
#pragma once
#include <limits>
#include <optional>

#include "ingest/scene.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/validation_record.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Moves a share of the training frames, at least one, to Split::kValidation and returns how many:
/// spread over cameras and timesteps, ends of a camera's sequence left where there are others; the
/// same for the same seed. Share 0: none. Errors: InputError: fewer than two training frames.
int64_t hold_out_validation(Scene& scene, double share, uint64_t seed);

/// The checks of one training.
class Validation {
 public:
  /// Of the frames of `scene` that are for validation; without any there are no checks. Backend and
  /// scene must outlive it.
  Validation(Backend& backend, const Scene& scene, const TrainOptions& options,
             ValidationRecord record = {});

  bool on() const { return frames_ > 0; }
  int64_t frames() const { return frames_; }
  /// The first step after `iteration` at which a check is due: every validate_interval steps,
  /// scaled as the schedule is, and the last.
  int64_t next_after(int64_t iteration) const;
  /// Whether a check is due after `iteration` steps and has not been made.
  bool due(int64_t iteration) const;
  /// Scores the model, in the host's memory or the backend's, and keeps a copy in the host's when
  /// it is the best so far.
  void check(const GaussianModel& model, int64_t iteration, double seconds);
  /// PSNR on the validation frames, dB. Errors: std::logic_error where there are none.
  double psnr(const GaussianModel& model) const;
  /// From now on models have the requested size: only these are shipped.
  void restart() {
    record_.restart();
    best_.reset();
  }

  /// Whether training is to end.
  bool stops() const { return record_.stopped; }
  const ValidationRecord& record() const { return record_; }
  /// Null before the first check, or when only the record was brought back.
  const GaussianModel* best() const { return best_ ? &*best_ : nullptr; }
  void restore_best(GaussianModel model) { best_ = std::move(model); }
  /// The best model without what can never be drawn, as a training's end leaves it.
  GaussianModel shipped() const;

 private:
  Backend& backend_;
  const Scene& scene_;
  int64_t frames_, interval_, iterations_, patience_, batch_;
  double within_db_;
  ValidationRecord record_;
  std::optional<GaussianModel> best_;
};

}  // namespace tessera
