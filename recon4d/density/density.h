// Adaptive density control of a set on any backend: clone, split and prune as index lists with one
// gather for each parameter group, opacity reset, and order for locality. The rule for one Gaussian
// is in kernels/edits/density.h, its children in split.h. Source: method A.13, A.14, D.7.
#pragma once
#include "kernels/backend.h"
#include "recon4d/model/gaussian_set.h"
#include "recon4d/options/train_options.h"

namespace tessera {

struct DensityReport {
  int64_t cloned = 0, split = 0, pruned = 0, before = 0, after = 0;
  int64_t relocated = 0, added = 0;  // by mcmc, which does none of the first three
};

struct DensityContext {
  const TrainOptions& options;
  double extent;     // E, world units
  bool prune_large;  // prune_extent holds
  int64_t room;      // Gaussians that may be added; < 0: no limit
  int64_t step;      // steps done; names the random numbers of the draw and of the split
};

/// DensityStatistics::length_share that a set is to gather. Where static Gaussians are halved, a
/// large one whose pixels do not agree grows, too: it covers a view between the cameras, in which
/// nothing has corrected it.
float length_share(const TrainOptions& options, SetForm form);

/// Element i of every group becomes its element values[i], of the moments element moments[i]; −1:
/// zeros.
void take_elements(Backend& backend, Span<const int64_t> values, Span<const int64_t> moments,
                   GaussianSet& set);

/// Σ of the scores of the Gaussians of a set that may grow.
double growth_weight(Backend& backend, const DensityContext& context, const GaussianSet& set,
                     const SetStatistics& statistics);

/// Clones, splits and prunes; new Gaussians have zero moments; statistics are reset.
DensityReport control_density(Backend& backend, const DensityContext& context, GaussianSet& set,
                              SetStatistics& statistics);

/// logit ← min(logit, logit 0.01), moments of the opacity zeroed. `filter_size`: of the 3D filter
/// where it dims: then what is 0.01 at most is the opacity after it.
void reset_opacity(Backend& backend, GaussianSet& set, Span<float> filter_size = {});

/// Morton order of the means; a dynamic set then stably by 32 bins of its temporal means. Of a set
/// of several SH degrees inside each block.
void reorder(Backend& backend, GaussianSet& set, SetStatistics& statistics);

/// Removes what can never be drawn: opacity below `least` (Cutoff), a quaternion without length.
/// Returns how many. For the end of a training.
int64_t prune_invisible(Backend& backend, GaussianSet& set, SetStatistics& statistics,
                        double least = 1.0 / 255);

}  // namespace tessera
