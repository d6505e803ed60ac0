// Forecast of the memory and time of a training: bytes of frames, Gaussians and steps, and seconds.
// Bytes of frames follow from the capture. Those of Gaussians, and the seconds, are models of
// measured runs (research/memory.md, research/results_history.md): 15 % on rigs, whose growth ends
// at its limit, a factor of 2 where it does not; a factor of 3 for the seconds.
#pragma once
#include <cstdint>
#include <string>

#include "ingest/scene.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Bytes are 3 a pixel of images and 1 of masks; a mask that frames share counts once.
struct ForecastLoad {
  int64_t training_frames = 0;
  int64_t pixels = 0;          // of the largest training frame
  int64_t image_bytes = 0;     // of the frames of all splits
  int64_t mask_bytes = 0;      // of the frames of all splits
  int64_t training_bytes = 0;  // of the images of training frames
  int64_t training_mask_bytes = 0;
  int64_t moving_mask_bytes = 0;  // of training frames, in place of those (moving_masks)
  bool still = false;             // one timestep
  bool rig = false;               // several cameras see a timestep of several
  int threads = 1;                // of the CPU
};

/// What a training of the scene would load, by its cameras, sizes and masks; no pixels are needed.
ForecastLoad forecast_load(const Scene& scene);

/// Images and masks that a training holds.
struct HeldImages {
  bool held_out = true;      // those of test and validation views, too
  bool moving_masks = true;  // a mask of what moves, for each training frame
};

/// Errors: InputError, before any image is read: what is held of a scene without pixels would take
/// nearly all of `memory`, bytes that programs can have in all.
void check_fits_memory(const Scene& scene, const HeldImages& held, int64_t memory);

struct TrainForecast {
  int64_t gaussians = 0;           // at the end of growth
  int64_t frame_bytes = 0;         // of frames and masks on the host
  int64_t device_frame_bytes = 0;  // of frames and masks on a device that has room for them
  int64_t parameter_bytes = 0;     // values and both Adam moments
  int64_t step_bytes = 0;          // buffers of a step, of growth and of decisions
  int64_t total_bytes = 0;         // of the host, without a device
  int64_t host_bytes = 0, device_bytes = 0;  // with one
  double cpu_seconds = 0, gpu_seconds = 0;   // of the steps; gpu: a card like an H200
};

TrainForecast forecast_training(const ForecastLoad& load, const TrainOptions& options);

}  // namespace tessera
