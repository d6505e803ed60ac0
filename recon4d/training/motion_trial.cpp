// The small scene of a motion trial, its trainings and their scores.
#include "recon4d/training/motion_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <future>
#include <mutex>
#include <set>

#include "kernels/base/errors.h"
#include "recon4d/motion/nodes.h"
#include "recon4d/training/scene_scale.h"
#include "recon4d/training/trainer.h"
#include "recon4d/training/validation.h"

namespace tessera {
namespace {

constexpr int64_t kLeastFrames = 24;
constexpr double kShare = 0.15;  // of the training frames, held out

/// What training reads of a scene, its images so small that steps are quick.
Scene small_scene(const Scene& scene) {
  Scene small;
  small.path = scene.path;
  small.points = scene.points;
  small.time_axis = scene.time_axis;
  small.background = scene.background;
  small.had_alpha = scene.had_alpha;
  for (const Frame& frame : scene.frames) {
    if (frame.split != Split::kTrain && frame.split != Split::kValidation) continue;
    const double pixels = double(frame.image.width) * double(frame.image.height);
    small.frames.push_back(
        scaled_frame(frame, std::min(1.0, std::sqrt(double(kTrialPixels) / pixels))));
  }
  return small;
}

/// What decides on the size of a model is left out: trials are compared while they grow.
TrainOptions trial_options(TrainOptions options) {
  options.iterations = kTrialIterations;
  options.batch = kTrialBatch;
  options.size = ModelSize::kGrown;
  options.decide_motion = options.decide_colour = false;
  options.max_gaussians = options.max_bytes = 0;
  options.within_db = 0;
  options.stop_patience = 0;
  return options;
}

/// In the host's memory; nothing where `stop` returned true.
std::optional<GaussianModel> trained_model(Backend& backend, const Scene& scene,
                                           const TrainOptions& options,
                                           const std::function<bool()>& stop) {
  Observer silent;
  std::string source;
  Trainer trainer(backend, scene, options, initial_state(scene, options, source), silent);
  trainer.run(options.iterations, stop);
  if (!trainer.state().finished) return std::nullopt;
  return trainer.host_model().clone_values();
}

/// Of the frames held out, all drawn as the middle of the clip.
double frozen_psnr(Backend& backend, Scene scene, const TrainOptions& options,
                   const GaussianModel& model) {
  for (Frame& frame : scene.frames) frame.time = 0.5;
  return Validation(backend, scene, options).psnr(model);
}

/// Trainings on one scene, side by side where the device can, else each when its model is asked
/// for.
class TrialRuns {
 public:
  TrialRuns(Backend& backend, const Scene& scene, const std::function<bool()>& stop)
      : backend_(backend), scene_(scene), stop_(stop) {}
  TrialRuns(const TrialRuns&) = delete;
  ~TrialRuns() { stopped_ = true; }  // and waits for those that are under way

  /// Its number.
  size_t add(const TrainOptions& options) {
    Run& run = runs_.emplace_back();
    run.options = options;
    const auto make = backend_.another();
    run.model = std::async(make ? std::launch::async : std::launch::deferred, [this, &run, make] {
      const std::unique_ptr<Backend> other = make ? make() : nullptr;
      return trained(other ? *other : backend_, run.options);
    });
    return runs_.size() - 1;
  }

  /// Nothing where it was stopped. One that found too little memory beside others is repeated
  /// alone.
  std::optional<GaussianModel> model(size_t number) {
    try {
      return runs_[number].model.get();
    } catch (const DeviceError&) {
      if (!side_by_side()) throw;
    }
    for (Run& run : runs_)
      if (run.model.valid()) run.model.wait();
    return trained(backend_, runs_[number].options);
  }

 private:
  struct Run {
    TrainOptions options;
    std::future<std::optional<GaussianModel>> model;
  };

  bool side_by_side() const { return backend_.another() != nullptr; }
  std::optional<GaussianModel> trained(Backend& backend, const TrainOptions& options) {
    return trained_model(backend, scene_, options, [this] {
      const std::lock_guard lock(asked_);
      stopped_ = stopped_ || stop_();
      return stopped_.load();
    });
  }

  Backend& backend_;
  const Scene& scene_;
  const std::function<bool()>& stop_;
  std::mutex asked_;
  std::atomic<bool> stopped_{false};
  std::deque<Run> runs_;
};

}  // namespace

std::string reason_against_trial(const Scene& scene, const TrainOptions& options) {
  std::set<int64_t> timesteps;
  int64_t frames = 0;
  bool shared = false;
  for (const Frame& frame : scene.frames) {
    if (frame.split != Split::kTrain && frame.split != Split::kValidation) continue;
    ++frames;
    shared = !timesteps.insert(frame.timestep).second || shared;
  }
  if (scene.is_static) return "the scene has one timestep";
  if (shared) return "several cameras see a timestep";
  if (frames < kLeastFrames)
    return fmt::format("{} training frames are too few to hold some out", frames);
  if (options.iterations < 2 * kTrialIterations)
    return fmt::format("a training of {} steps is short beside a trial", options.iterations);
  return "";
}

std::optional<MotionTrial> try_motion(Backend& backend, const Scene& scene,
                                      const TrainOptions& with_nodes,
                                      const std::function<bool()>& stop) {
  Scene small = small_scene(scene);
  if (small.split_indices(Split::kValidation).empty())
    hold_out_validation(small, kShare, uint64_t(with_nodes.seed));
  MotionTrial trial;
  trial.frames = int64_t(small.split_indices(Split::kValidation).size());
  const bool chooses_number = with_nodes.motion_nodes == 0;
  TrainOptions of_nodes = trial_options(with_nodes);
  of_nodes.motion = Motion::kNodes;
  TrainOptions of_pairs = of_nodes, of_many = of_nodes;
  of_pairs.motion = Motion::kPair;
  of_pairs.min_blending_weight =
      0;  // of sets that one view a timestep sees: removes what is hidden
  of_many.motion_nodes = kManyNodes;
  TrialRuns runs(backend, small, stop);
  const size_t pairs = runs.add(of_pairs), nodes = runs.add(of_nodes);
  const size_t many = chooses_number ? runs.add(of_many) : nodes;
  const std::optional<GaussianModel> with_pairs = runs.model(pairs);
  if (!with_pairs) return std::nullopt;
  const std::optional<GaussianModel> with_few = runs.model(nodes);
  if (!with_few) return std::nullopt;
  const Validation held_out(backend, small, of_nodes);
  trial.dynamic_psnr = held_out.psnr(*with_pairs);
  trial.nodes_psnr = held_out.psnr(*with_few);
  trial.frozen_psnr = frozen_psnr(backend, small, of_nodes, *with_few);
  if (!trial.prefers_nodes() || !chooses_number) return trial;
  const std::optional<GaussianModel> with_many = runs.model(many);
  if (!with_many) return std::nullopt;
  trial.many_nodes_psnr = held_out.psnr(*with_many);
  return trial;
}

}  // namespace tessera
