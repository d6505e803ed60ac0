// Times of the stages of a training step on a fixed load: the training views of a scene in turn, a
// trained model or a given number of Gaussians, and learning rates of zero, so that the load stays.
#pragma once
#include <array>

#include "ingest/scene.h"
#include "kernels/backend.h"
#include "recon4d/model/gaussian_set.h"
#include "recon4d/options/train_options.h"

namespace tessera {

struct StageBenchOptions {
  const GaussianModel* model = nullptr;  // null: the scene's initial Gaussians
  int64_t gaussians = 0;  // copies of the initial ones, moved by their size; 0: as they are
  double opacity = 0.5;   // of all of them
  int64_t steps = 30, warm_up = 5;
};

struct StageBenchReport {
  int64_t gaussians = 0, splats = 0, instances = 0, pixels = 0;
  double step_seconds = 0;                    // wall time of a step
  std::array<StageTotals, kStages> stages{};  // per step
  int64_t peak_bytes = 0;                     // ground truth included
};

/// Steps of a Trainer with the options, learning rates and density control left out; without
/// reordering the Gaussians are shuffled.
/// Errors: InputError: an option out of range, no training frames, no points.
StageBenchReport bench_stages(Backend& backend, const Scene& scene, const TrainOptions& options,
                              const StageBenchOptions& bench);

/// Bytes read plus bytes written per second by a large copy inside the backend's memory: the
/// ceiling of every stage that only moves data.
double copy_bytes_per_second(Backend& backend);

}  // namespace tessera
