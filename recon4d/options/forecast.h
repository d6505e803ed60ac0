// Forecast of the memory and time of a training: bytes of frames, Gaussians and steps, and seconds.
// Bytes follow from the layout of the data; the number of Gaussians and the seconds are models of
// measured runs (research/results_history.md) and right within a factor of 2 to 3.
#pragma once
#include <cstdint>
#include <string>

#include "recon4d/options/train_options.h"

namespace tessera {

struct ForecastLoad {
  int64_t training_frames = 0;
  int64_t pixels = 0;     // of the largest frame
  int64_t all_bytes = 0;  // of the pixels of all training frames, 3 a pixel
  int threads = 1;        // of the CPU
};

struct TrainForecast {
  int64_t gaussians = 0;        // at the end
  int64_t frame_bytes = 0;      // resident, on the host and on the device
  int64_t parameter_bytes = 0;  // values and both Adam moments
  int64_t step_bytes = 0;       // buffers of a step: pixels and splats
  int64_t total_bytes = 0;
  double cpu_seconds = 0, gpu_seconds = 0;  // of the steps; gpu: a card like an H200
};

TrainForecast forecast_training(const ForecastLoad& load, const TrainOptions& options);

}  // namespace tessera
