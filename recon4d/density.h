// What: adaptive density control of a set: clone, split, prune as index lists and one gather per
//       parameter group; opacity reset; order for locality.
// Not: when (schedule.h). Statistics come from the backward pass.
// Source: method A.13, A.14, D.7.
#pragma once
#include "kernels/backend.h"
#include "recon4d/gaussian_set.h"
#include "recon4d/train_options.h"

namespace tessera {

/// What a set has gathered since the last density control.
struct SetStatistics {
  Buffer<float> gradient_sum, count;  // [N] as DensityStatistics

  void reset(int64_t gaussians);
  DensityStatistics<float> spans() { return {gradient_sum.span(), count.span()}; }
};

struct DensityReport {
  int64_t cloned = 0, split = 0, pruned = 0, before = 0, after = 0;
};

struct DensityContext {
  const TrainOptions& options;
  double extent;     // E, world units
  bool prune_large;  // prune_extent holds
  int64_t room;      // Gaussians that may be added; < 0: no limit
  uint64_t draw;     // names the random numbers of the split: the step
};

/// Clones, splits and prunes; new Gaussians have zero moments; statistics are reset.
DensityReport control_density(Backend& backend, const DensityContext& context, GaussianSet& set,
                              SetStatistics& statistics);

/// logit ← min(logit, logit 0.01), moments of the opacity zeroed.
void reset_opacity(GaussianSet& set);

/// Morton order of the means; a dynamic set then stably by 32 bins of its temporal means.
void reorder(Backend& backend, GaussianSet& set, SetStatistics& statistics);

/// Removes what can never be drawn: opacity below 1/255, a quaternion without length. Returns how
/// many. For the end of a training.
int64_t prune_invisible(Backend& backend, GaussianSet& set, SetStatistics& statistics);

}  // namespace tessera
