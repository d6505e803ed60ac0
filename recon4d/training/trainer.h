// The training loop: schedule, batch, forward pass, loss, and backward pass with the optimizer as
// its sink. It reports to an Observer; files, printing and evaluation happen in tools/ between
// calls of `run`. Source: method A.3 and D.6 for the order of events in a step.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "kernels/base/camera_rig.h"
#include "kernels/pipeline.h"
#include "recon4d/density/density.h"
#include "recon4d/evaluation/scoring_pass.h"
#include "recon4d/model/clocks.h"
#include "recon4d/model/train_state.h"
#include "recon4d/training/batch_sampler.h"
#include "recon4d/training/frame_cache.h"
#include "recon4d/training/schedule.h"

namespace tessera {

struct StepReport {
  int64_t iteration = 0;              // steps done, this one included
  double loss = 0, l1 = 0, ssim = 0;  // mean over the batch
  int64_t num_static = 0, num_dynamic = 0;
  int64_t splats = 0, instances = 0, invalid_gaussians = 0;
  int64_t pixels = 0;      // of the batch
  int64_t peak_bytes = 0;  // of the backend's memory, so far
  double seconds = 0;      // since the report before, or since `run` began
};

class Observer {
 public:
  virtual ~Observer() = default;
  /// In the order of steps; up to one step late, but before `run` returns.
  virtual void on_step(const StepReport&) {}
  /// After a density control; `set` is "static" or "dynamic".
  virtual void on_density(int64_t, const std::string&, const DensityReport&) {}
};

class Trainer {
 public:
  /// Takes the state, in the host's memory, into the backend's. `scene` must outlive the trainer.
  /// Errors: InputError: no training frames.
  Trainer(Backend& backend, const Scene& scene, const TrainOptions& options, TrainState state,
          Observer& observer);

  /// Steps until `iteration` steps are done in all, or `stop` returns true (called before each
  /// step). At options.iterations the model is cleaned up and `finished` set. All steps are
  /// reported before it returns. Errors: NumericalError naming step and parameter when a gradient
  /// or the loss is not finite; the state then is not to be used: the optimizer has already taken
  /// the step.
  void run(int64_t iteration, const std::function<bool()>& stop = {});

  /// As it is, in the backend's memory: for its numbers.
  const TrainState& state() const { return state_; }
  /// The same in the host's memory, e.g. for a checkpoint. Valid until the next step.
  const TrainState& host_state();
  /// The model in the host's memory as it is drawn, e.g. for evaluation. Valid until the next step.
  const GaussianModel& host_model();
  /// The model as it is drawn: in the backend's memory where the state is drawn as it is stored,
  /// else host_model(). Valid until the next step.
  const GaussianModel& drawn_model();
  /// Waits for the last step and frees the buffers that only a step needs, on a device: what
  /// measures the model next takes their place. The next step allocates them again.
  void release_step_buffers();
  /// Changes the Gaussians of the state where the backend has it. Errors: as apply_edit.
  void apply(const StateEdit& edit);
  /// Records that a decision was made after the steps that are done: the Gaussians that pruning is
  /// to leave (0: not known yet), and the seconds that it took.
  void record(int64_t goal, double seconds);
  /// Training frames with the maps of colours they have now, and their images where all are on the
  /// device.
  FrameSample sample_frames();
  const TrainOptions& options() const { return options_; }
  /// What the removal of Gaussians that no view shows has taken of the steps so far.
  double unseen_seconds() const { return unseen_seconds_; }
  /// What state().exposure has a row for.
  const ExposureRows& exposed() const { return exposed_; }
  /// What state().clocks has a row for.
  const ClockRows& clocked() const { return clocked_; }

 private:
  void step();
  /// Without views.
  ForwardArgs<float> forward_args() const;
  void control();
  void measure_filter(int k);
  void densify();
  void prune_unseen();
  void prune_free_space();
  /// Motion nodes where they start, and more control points where these are due.
  void control_nodes();
  void step_nodes();
  /// Gaussians that there may be after the next density control; 0: no limit.
  int64_t limit_of_growth() const;
  /// Of the Gaussians that both sets may grow by, the share of the static one: that of its
  /// Gaussians, or in a draw that of their scores.
  double static_share() const;
  /// Of those up to `limit`, how many set k may grow by; −1: no limit.
  int64_t room_of(int k, int64_t limit, double static_share) const;
  DensityContext density_context(int64_t room) const;
  void backward();
  /// Maps of colours of the views of a batch; empty: none.
  std::vector<ColourMap<double>> maps(const std::vector<int64_t>& batch) const;
  /// Of a training frame, as far as it is learnt.
  CameraClock clock_of(int64_t index) const;
  /// Colours and clocks, by the gradients of the last step, which was step i.
  void step_rows(const StepOutcome& outcome, int64_t i);
  void prefetch();
  /// Reports the last step once the backend has its outcome.
  void complete_pending();
  void finish();
  void forget_copies() {
    host_state_.reset();
    host_model_.reset();
  }

  Backend& backend_;
  const Scene& scene_;
  TrainOptions options_;
  TrainState state_;
  Observer& observer_;
  std::vector<int> train_frames_;  // before the rig, which needs one
  CameraRig rig_;
  Schedule schedule_;
  BatchSampler sampler_;
  FrameCache cache_;
  Pipeline<float> pipeline_;
  GaussianSet gradients_[2];  // only with a separate optimizer
  /// Only with a 3D filter: of the static set every camera once, of the dynamic one every frame.
  ViewBatch<float> filter_views_[2];
  int64_t timesteps_;  // of the training frames
  double unseen_seconds_ = 0;
  MotionNodes d_nodes_;  // gradients
  Buffer<float> d_environment_;
  ExposureRows exposed_;
  ClockRows clocked_;
  std::vector<ColourMap<double>> maps_;  // [R] of the next step
  std::vector<CameraClock> clocks_;      // [R] of the next step
  std::vector<int64_t> pending_batch_;   // [B] training frames of the last step
  std::optional<StepReport> pending_;
  std::chrono::steady_clock::time_point reported_;  // until when time is accounted for
  std::optional<TrainState> host_state_;
  std::optional<GaussianModel> host_model_;
};

/// The state before step 0. `shared`: a static set that stays as it is; null: none. Errors: as
/// initialise_model and exposure_rows.
TrainState initial_state(const Scene& scene, const TrainOptions& options, std::string& source,
                         const GaussianSet* shared = nullptr);

}  // namespace tessera
