// The small scene of a motion trial, its trainings and their scores.
#include "recon4d/training/motion_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

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
  TrainOptions options = trial_options(with_nodes);
  options.motion = Motion::kPair;
  options.min_blending_weight = 0;  // of sets that one view a timestep sees: removes what is hidden
  const std::optional<GaussianModel> dynamic = trained_model(backend, small, options, stop);
  if (!dynamic) return std::nullopt;
  options.motion = Motion::kNodes;
  options.min_blending_weight = with_nodes.min_blending_weight;
  const std::optional<GaussianModel> nodes = trained_model(backend, small, options, stop);
  if (!nodes) return std::nullopt;
  const Validation held_out(backend, small, options);
  trial.dynamic_psnr = held_out.psnr(*dynamic);
  trial.nodes_psnr = held_out.psnr(*nodes);
  trial.frozen_psnr = frozen_psnr(backend, small, options, *nodes);
  if (!trial.prefers_nodes() || with_nodes.motion_nodes > 0) return trial;
  options.motion_nodes = kManyNodes;
  const std::optional<GaussianModel> many = trained_model(backend, small, options, stop);
  if (!many) return std::nullopt;
  trial.many_nodes_psnr = held_out.psnr(*many);
  return trial;
}

}  // namespace tessera
