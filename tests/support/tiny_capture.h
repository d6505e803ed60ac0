// Captures of a few known Gaussians, rendered by the CPU backend into a Scene in memory, and
// trainings on them whose state tests can read.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "recon4d/reduction/model_reduction.h"
#include "recon4d/training/trainer.h"
#include "recon4d/training/validation.h"

namespace tessera::testing {

/// A ring of cameras around the origin, each with `timesteps` frames from time 0 to 1.
struct TinyCapture {
  int cameras = 6, timesteps = 4, size = 20;  // images are size × size
  double arc = 6.283185307179586;             // of the ring that the cameras share, radians
  bool moving = true;                         // two of the five blobs move
  std::array<uint8_t, 3> background{0, 0, 0};
};

/// The content of the images: three static blobs, and two dynamic ones when `moving`.
GaussianModel tiny_truth(const TinyCapture& capture);
/// Frames ordered by camera, then time; all of the training split. `had_alpha` is set, so initial
/// points fill a box.
Scene tiny_capture(const TinyCapture& capture = {});
/// The same ring around given Gaussians.
Scene tiny_capture(const TinyCapture& capture, const GaussianModel& truth);
/// Uniform noise on every value of every image, at most `most` in 8-bit units.
void add_noise(Scene& scene, double most, uint64_t seed);
/// Short enough for a test, with every event of the schedule in it.
TrainOptions tiny_options();
/// Grows until 100, thins out at 101, 127, 153 and 180, decides on motion at 30, 60 and 90.
TrainOptions thrifty_options();
/// A made-up size of the shipped file.
int64_t made_bytes(const GaussianModel& model);

/// A trainer with all it refers to, and the reports to its observer.
class Training : private Observer {
 public:
  Training(const Scene& scene, const TrainOptions& options);
  Training(const Scene& scene, const TrainOptions& options, TrainState state);
  Training(const Scene& scene, const TrainOptions& options, TrainState state, Backend& backend);

  Training& run(int64_t iteration, const std::function<bool()>& stop = {});
  Training& run() { return run(trainer_.options().iterations); }

  /// With the checks that fall due, until `iteration` steps or the stop.
  Training& run(int64_t iteration, Validation& validation);

  /// The check of a model that falls due now.
  void check_if_due(Validation& validation);

  /// With the decisions that fall due too, in the order in which the program takes them.
  Training& run(int64_t iteration, ModelReduction& reduction, Validation& validation);
  const std::vector<ReductionReport>& decisions() const { return decisions_; }

  const TrainState& state() const { return trainer_.state(); }
  const GaussianModel& model() const { return trainer_.state().model; }
  const std::vector<StepReport>& steps() const { return steps_; }
  const std::vector<DensityReport>& density() const { return density_; }
  Backend& backend() { return backend_; }
  Trainer& trainer() { return trainer_; }
  /// PSNR of all training frames, un-quantised.
  double psnr() const;

 private:
  void on_step(const StepReport& report) override { steps_.push_back(report); }
  void on_density(int64_t, const std::string&, const DensityReport& report) override {
    density_.push_back(report);
  }

  const Scene& scene_;
  std::unique_ptr<Backend> own_backend_;
  Backend& backend_;
  std::vector<StepReport> steps_;
  std::vector<DensityReport> density_;
  std::vector<ReductionReport> decisions_;
  Trainer trainer_;
};

/// The state before step 0, without its description.
TrainState first_state(const Scene& scene, const TrainOptions& options);

/// Counts and the bits of every value of both sets: equal if and only if the models are.
std::vector<uint32_t> model_bits(const GaussianModel& model);
/// The same with moments, statistics and the numbers of the state; without the time it took.
std::vector<uint32_t> state_bits(const TrainState& state);

}  // namespace tessera::testing
