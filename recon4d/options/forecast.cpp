// Sums of bytes in 64 bits, and the constants of the two models of time.
#include "recon4d/options/forecast.h"

#include <algorithm>

#include "kernels/gaussians.h"
#include "kernels/math/spherical_harmonics.h"

namespace tessera {
namespace {

// A set without a limit: 1.0 million on dnerf_lego and 1.1 on bonsai after 30,000 steps.
constexpr int64_t kUnlimited = 1000000;
constexpr int64_t kPixelBytes = 68;  // eight floats a pixel, nine for the loss
constexpr int64_t kSplatBytes = 168;
// Of motion nodes: weights and sorted bindings of a Gaussian; its place in a view and gradients.
constexpr int64_t kBindingBytes = 176, kCarriedBytes = 73;
constexpr double kVisible = 0.4;       // splats by views and Gaussians
constexpr double kMeanShare = 0.75;    // mean size of the set over the training, by the last
constexpr double kCpuPixel = 0.4e-6;   // seconds a pixel and thread: 14.5 steps a second
constexpr double kCpuSplat = 0.58e-6;  //   at 240 × 180 with 30,000 Gaussians, 2 threads
constexpr double kGpuStep = 0.7e-3;    // seconds a step, by dnerf_lego, mic and bonsai
constexpr double kGpuPixel = 0.05e-9, kGpuSplat = 0.45e-9;  //   on an H200

/// A value and two moments of each scalar; those of SH share a word.
int64_t element_bytes(SetForm form, int64_t time_levels) {
  const int64_t sh = 3 * kMaxShCoefficients * (1 + time_levels);
  return (trained_geometry_scalars(form) + 2 * sh) * int64_t(sizeof(float));
}

/// Of the larger set.
SetForm trained_form(Motion motion) {
  if (motion == Motion::kNone) return SetForm::kStatic;
  return motion == Motion::kNodes ? SetForm::kCanonical : dynamic_form_of(motion);
}

/// The time of the two short trainings that decide on motion.
void add_trials(ForecastLoad load, TrainOptions options, TrainForecast& forecast) {
  load.pixels = std::min(load.pixels, kTrialPixels);
  options.motion = Motion::kPair;
  options.iterations = kTrialIterations;
  options.batch = kTrialBatch;
  const TrainForecast trial = forecast_training(load, options);
  forecast.cpu_seconds += 2 * trial.cpu_seconds;
  forecast.gpu_seconds += 2 * trial.gpu_seconds;
}

}  // namespace

TrainForecast forecast_training(const ForecastLoad& load, const TrainOptions& options) {
  TrainForecast forecast;
  forecast.gaussians =
      std::max(options.init_points, growth_limit(options) > 0 ? growth_limit(options) : kUnlimited);
  forecast.frame_bytes = load.all_bytes;
  const SetForm form = trained_form(options.motion);
  const bool in_time = form == SetForm::kPair || form == SetForm::kVelocity;
  forecast.parameter_bytes =
      forecast.gaussians * element_bytes(form, in_time ? options.sh_time_degree : 0);
  const int64_t batch = std::min(options.batch, std::max<int64_t>(1, load.training_frames));
  const double splats = kVisible * double(forecast.gaussians) * double(batch);
  forecast.step_bytes = batch * load.pixels * kPixelBytes + int64_t(splats) * kSplatBytes;
  if (form == SetForm::kCanonical)
    forecast.step_bytes += forecast.gaussians * (kBindingBytes + batch * kCarriedBytes);
  forecast.total_bytes = forecast.frame_bytes + forecast.parameter_bytes + forecast.step_bytes;
  const double steps = double(options.iterations);
  const double pixels = double(batch) * double(load.pixels);
  const double elements = kMeanShare * double(forecast.gaussians) * double(batch);
  forecast.cpu_seconds =
      steps * (kCpuPixel * pixels + kCpuSplat * elements) / std::max(1, load.threads);
  forecast.gpu_seconds = steps * (kGpuStep + kGpuPixel * pixels + kGpuSplat * elements);
  if (options.motion == Motion::kAuto) add_trials(load, options, forecast);
  return forecast;
}

}  // namespace tessera
