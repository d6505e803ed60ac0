// What: the training loop: schedule, batch, forward, loss, backward with the optimizer as its sink.
// Not: files, printing, evaluation (tools/ drives those between calls of `run`).
// Source: method A.3 and D.6 for the order of events in a step.
#pragma once
#include <functional>

#include "kernels/pipeline.h"
#include "recon4d/batch_sampler.h"
#include "recon4d/camera_rig.h"
#include "recon4d/density.h"
#include "recon4d/observer.h"
#include "recon4d/schedule.h"

namespace tessera {

/// Everything a training needs to go on exactly as if it had not stopped.
struct TrainState {
  GaussianModel model;
  SetStatistics statistics[2];  // static, dynamic
  int64_t iteration = 0;        // steps done
  int64_t sampler_epoch = 0, sampler_position = 0;
  double seconds = 0;     // spent in steps
  bool finished = false;  // the last clean-up is done
};

class Trainer {
 public:
  /// `scene` must outlive the trainer. Errors: InputError: no training frames.
  Trainer(Backend& backend, const Scene& scene, const TrainOptions& options, TrainState state,
          Observer& observer);

  /// Steps until `iteration` steps are done in all, or `stop` says so (asked before each step).
  /// At options.iterations the model is cleaned up and `finished` set.
  /// Errors: NumericalError naming step and parameter when a gradient or the loss is not finite;
  /// the state then is not to be used: the fused optimizer has already taken the step.
  void run(int64_t iteration, const std::function<bool()>& stop = {});

  const TrainState& state() const { return state_; }
  const TrainOptions& options() const { return options_; }
  const std::array<double, kStages>& stage_seconds() const { return pipeline_.stage_seconds(); }

 private:
  StepReport step();
  void control();
  /// Gaussians that set k may grow by; −1: no limit.
  int64_t room_of(int k) const;
  unsigned backward();
  void finish();
  GaussianSet& set(int i) { return i == 0 ? state_.model.static_set : state_.model.dynamic_set; }

  Backend& backend_;
  const Scene& scene_;
  TrainOptions options_;
  TrainState state_;
  Observer& observer_;
  std::vector<int> train_frames_;  // before the rig, which needs one
  CameraRig rig_;
  Schedule schedule_;
  BatchSampler sampler_;
  Pipeline<float> pipeline_;
  GaussianSet gradients_[2];  // only with a separate optimizer
};

/// The state before step 0. Errors: as initialise_model.
TrainState initial_state(const Scene& scene, const TrainOptions& options, std::string& source);

}  // namespace tessera
