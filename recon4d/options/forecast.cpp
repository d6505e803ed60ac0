// Sums of bytes in 64 bits, and the constants of the two models of time.
#include "recon4d/options/forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "kernels/base/errors.h"
#include "kernels/gaussians.h"
#include "kernels/math/spherical_harmonics.h"

namespace tessera {
namespace {

// A set without a limit: 1.0 million on dnerf_lego and 1.1 on bonsai after 30,000 steps.
constexpr int64_t kUnlimited = 1000000;
// Where one camera sees a timestep growth ends before its limit: 100,000 in 7,000 steps at most.
constexpr int64_t kGrownOfOneCamera = 100000, kStepsOfGrowth = 7000;
constexpr int64_t kMiB = int64_t{1} << 20;
constexpr int64_t kLibraries = 118 * kMiB;  // of media, which the complete program has
constexpr int64_t kProgram = kLibraries + 60 * kMiB;
constexpr int64_t kWithDevice = kLibraries + 252 * kMiB;  // with the libraries of a device
constexpr int64_t kScoredPixel = 706;  // bytes: planes of four views that are scored side by side
constexpr int64_t kOnDevice = 48 * kMiB;  // of scratch memory and blocks that are not full
constexpr int64_t kDecision = 1700;       // bytes of a Gaussian whose motion is decided on
constexpr int64_t kPixelBytes = 68;       // eight floats a pixel, nine for the loss
constexpr int64_t kSplatBytes = 168;
// Of motion nodes: weights and sorted bindings of a Gaussian; its place in a view and gradients.
constexpr int64_t kBindingBytes = 176, kCarriedBytes = 73;
constexpr double kVisible = 0.4;       // splats by views and Gaussians
constexpr double kMeanShare = 0.75;    // mean size of the set over the training, by the last
constexpr double kCpuPixel = 0.4e-6;   // seconds a pixel and thread: 14.5 steps a second
constexpr double kCpuSplat = 0.58e-6;  //   at 240 × 180 with 30,000 Gaussians, 2 threads
constexpr double kGpuStep = 0.7e-3;    // seconds a step, by dnerf_lego, mic and bonsai
constexpr double kGpuPixel = 0.05e-9, kGpuSplat = 0.45e-9;  //   on an H200
constexpr double kGpuRigPixel = 0.5e-9;  // whose images are full; of 1352 × 1014 pixels

/// A value and two moments of each scalar; those of SH share a word.
int64_t element_bytes(SetForm form, int64_t time_levels) {
  const int64_t sh = 3 * kMaxShCoefficients * (1 + time_levels);
  return (trained_geometry_scalars(form) + 2 * sh) * int64_t(sizeof(float));
}

/// A value of each scalar.
int64_t value_bytes(SetForm form, int64_t time_levels) {
  const int64_t sh = 3 * kMaxShCoefficients * (1 + time_levels);
  return (trained_geometry_scalars(form) / 3 + sh) * int64_t(sizeof(float));
}

int64_t grown(const ForecastLoad& load, const TrainOptions& options) {
  const int64_t limit = growth_limit(options);
  if (limit == 0) return kUnlimited;
  if (load.rig) return limit;
  return std::min(limit, kGrownOfOneCamera * options.iterations / kStepsOfGrowth);
}

/// Of a mask whose pixels are not among `known`, which it joins.
int64_t new_bytes(const FrameMask& mask, std::set<const Image8*>& known) {
  if (mask.shared() == nullptr || !known.insert(mask.shared()).second) return 0;
  return int64_t(mask.image().width) * mask.image().height;
}

/// Whether these frames of a camera have a median over time, by which moving pixels are marked.
bool has_median(const std::vector<const Frame*>& frames) {
  constexpr size_t kLeast = 3;  // DynamicRegions::kLeastMoments
  return frames.size() >= kLeast &&
         std::all_of(frames.begin(), frames.end(),
                     [&](const Frame* frame) { return frame->camera == frames.front()->camera; });
}

/// Of the larger set.
SetForm trained_form(Motion motion) {
  if (motion == Motion::kNone) return SetForm::kStatic;
  return motion == Motion::kNodes ? SetForm::kCanonical : dynamic_form_of(motion);
}

/// The time of the short trainings that decide on motion and, where it is not stated, on the number
/// of nodes.
void add_trials(ForecastLoad load, TrainOptions options, TrainForecast& forecast) {
  load.pixels = std::min(load.pixels, kTrialPixels);
  options.motion = Motion::kPair;
  options.iterations = kTrialIterations;
  options.batch = kTrialBatch;
  const TrainForecast trial = forecast_training(load, options);
  const double trials = options.motion_nodes > 0 ? 2 : 3;
  forecast.cpu_seconds += trials * trial.cpu_seconds;
  forecast.gpu_seconds += trials * trial.gpu_seconds;
}

}  // namespace

ForecastLoad forecast_load(const Scene& scene) {
  ForecastLoad load;
  std::set<const Image8*> masks, training_masks;
  std::map<std::string, std::vector<const Frame*>> cameras;  // by name, of training frames
  for (const Frame& frame : scene.frames) {
    const int64_t pixels = int64_t(frame.camera.width) * frame.camera.height;
    load.image_bytes += 3 * pixels;
    load.mask_bytes += new_bytes(frame.mask, masks);
    if (frame.split != Split::kTrain) continue;
    ++load.training_frames;
    load.pixels = std::max(load.pixels, pixels);
    load.training_bytes += 3 * pixels;
    load.training_mask_bytes += new_bytes(frame.mask, training_masks);
    cameras[frame.camera_name].push_back(&frame);
  }
  std::set<const Image8*> kept;
  for (const auto& [name, frames] : cameras) {
    const bool known = has_median(frames);
    for (const Frame* const frame : frames)
      load.moving_mask_bytes += known ? int64_t(frame->camera.width) * frame->camera.height
                                      : new_bytes(frame->mask, kept);
  }
  const int64_t timesteps = scene.timesteps_of(Split::kTrain);
  load.still = timesteps <= 1;
  load.rig = timesteps > 1 && load.training_frames > timesteps;
  return load;
}

void check_fits_memory(const Scene& scene, const HeldImages& held, int64_t memory) {
  constexpr double kMost = 0.9;
  const ForecastLoad load = forecast_load(scene);
  const int64_t bytes = (held.held_out ? load.image_bytes : load.training_bytes) + load.mask_bytes +
                        (held.moving_masks ? load.moving_mask_bytes : 0);
  if (double(bytes) <= kMost * double(memory)) return;
  throw InputError(fmt::format(
      "{}: its images take {:.1f} GB, and this machine has {:.1f} GB of memory; train a rig of "
      "fixed cameras in windows (--windows auto), or prepare the capture with a smaller --scale",
      scene.path, double(bytes) / 1e9, double(memory) / 1e9));
}

TrainForecast forecast_training(const ForecastLoad& load, const TrainOptions& options) {
  TrainForecast forecast;
  forecast.gaussians = std::max(options.init_points, grown(load, options));
  const bool weighs_motion = options.moving_weight > 0;
  forecast.device_frame_bytes =
      load.training_bytes + (weighs_motion ? load.moving_mask_bytes : load.training_mask_bytes);
  forecast.frame_bytes =
      load.image_bytes + load.mask_bytes + (weighs_motion ? load.moving_mask_bytes : 0);
  const SetForm form = load.still ? SetForm::kStatic : trained_form(options.motion);
  const bool in_time = form == SetForm::kPair || form == SetForm::kVelocity;
  const int64_t time_levels = in_time ? options.sh_time_degree : 0;
  forecast.parameter_bytes = forecast.gaussians * element_bytes(form, time_levels);
  const int64_t batch = std::min(options.batch, std::max<int64_t>(1, load.training_frames));
  const double splats = kVisible * double(forecast.gaussians) * double(batch);
  forecast.step_bytes = batch * load.pixels * kPixelBytes + int64_t(splats) * kSplatBytes;
  if (form == SetForm::kCanonical)
    forecast.step_bytes += forecast.gaussians * (kBindingBytes + batch * kCarriedBytes);
  // gradients, and the set again while it changes its length
  const int64_t values = forecast.gaussians * value_bytes(form, time_levels);
  forecast.step_bytes += values + forecast.parameter_bytes;
  if (form != SetForm::kStatic && options.decide_motion)
    forecast.step_bytes += forecast.gaussians * kDecision;
  const int64_t model_bytes = forecast.parameter_bytes + forecast.step_bytes;
  const int64_t while_scored = load.image_bytes + load.mask_bytes + kScoredPixel * load.pixels;
  forecast.total_bytes = kProgram + std::max(forecast.frame_bytes + model_bytes, while_scored);
  forecast.host_bytes =
      kWithDevice + std::max(forecast.frame_bytes + forecast.parameter_bytes, while_scored);
  forecast.device_bytes = kOnDevice + forecast.device_frame_bytes + model_bytes;
  const double steps = double(options.iterations);
  const double pixels = double(batch) * double(load.pixels);
  const double elements = kMeanShare * double(forecast.gaussians) * double(batch);
  forecast.cpu_seconds =
      steps * (kCpuPixel * pixels + kCpuSplat * elements) / std::max(1, load.threads);
  const double pixel = load.rig ? kGpuRigPixel : kGpuPixel;
  forecast.gpu_seconds = steps * (kGpuStep + pixel * pixels + kGpuSplat * elements);
  if (options.motion == Motion::kAuto && !load.still) add_trials(load, options, forecast);
  return forecast;
}

}  // namespace tessera
