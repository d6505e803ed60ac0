// What: 64-bit sums and the constants of the two time models.
// Not: the free memory of this machine.
#include "recon4d/options/forecast.h"

#include <algorithm>

#include "kernels/gaussians.h"
#include "kernels/math/spherical_harmonics.h"
#include "recon4d/options/kernel_options.h"

namespace tessera {
namespace {

// A set without a limit: 1.0 million on dnerf_lego and 1.1 on bonsai after 30,000 steps.
constexpr int64_t kUnlimited = 1000000;
constexpr int64_t kPixelBytes = 68;  // eight floats a pixel, nine for the loss
constexpr int64_t kSplatBytes = 168;
constexpr double kVisible = 0.4;       // splats by views and Gaussians
constexpr double kMeanShare = 0.75;    // mean size of the set over the training, by the last
constexpr double kCpuPixel = 0.4e-6;   // seconds a pixel and thread: 14.5 steps a second
constexpr double kCpuSplat = 0.58e-6;  //   at 240 × 180 with 30,000 Gaussians, 2 threads
constexpr double kGpuStep = 0.7e-3;    // seconds a step, by dnerf_lego, mic and bonsai
constexpr double kGpuPixel = 0.05e-9, kGpuSplat = 0.45e-9;  //   on an H200

/// A value and two moments of each scalar; those of SH share a word.
int64_t element_bytes(Form form, int64_t time_levels) {
  const int64_t sh = 3 * kMaxShCoefficients * (1 + time_levels);
  return (trained_geometry_scalars(form) + 2 * sh) * int64_t(sizeof(float));
}

}  // namespace

TrainForecast forecast_training(const ForecastLoad& load, const TrainOptions& options) {
  TrainForecast forecast;
  forecast.gaussians =
      std::max(options.init_points, growth_limit(options) > 0 ? growth_limit(options) : kUnlimited);
  forecast.frame_bytes = load.all_bytes;
  forecast.parameter_bytes =
      forecast.gaussians * (options.motion == Motion::kNone
                                ? element_bytes(Form::kStatic, 0)
                                : element_bytes(dynamic_form(options), options.sh_time_degree));
  const int64_t batch = std::min(options.batch, std::max<int64_t>(1, load.training_frames));
  const double splats = kVisible * double(forecast.gaussians) * double(batch);
  forecast.step_bytes = batch * load.pixels * kPixelBytes + int64_t(splats) * kSplatBytes;
  forecast.total_bytes = forecast.frame_bytes + forecast.parameter_bytes + forecast.step_bytes;
  const double steps = double(options.iterations);
  const double pixels = double(batch) * double(load.pixels);
  const double elements = kMeanShare * double(forecast.gaussians) * double(batch);
  forecast.cpu_seconds =
      steps * (kCpuPixel * pixels + kCpuSplat * elements) / std::max(1, load.threads);
  forecast.gpu_seconds = steps * (kGpuStep + kGpuPixel * pixels + kGpuSplat * elements);
  return forecast;
}

}  // namespace tessera
