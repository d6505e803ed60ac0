// Pruning of Gaussians that no training view shows: the largest blending weight of each Gaussian
// over all pixels of the views, and the removal of those below a threshold. They cost memory and
// appear from other directions, where no image constrains them.
#pragma once
#include <array>
#include <functional>
#include <vector>

#include "kernels/pipeline.h"
#include "recon4d/density/density.h"
#include "recon4d/model/train_state.h"

namespace tessera {

/// Training views in which Gaussians are looked for.
struct SampledViews {
  std::vector<View> views;
  bool all = false;  // those of all training frames
};

/// Views that may show a Gaussian of either set: those of all training frames, or where these are
/// more than `enough`, of every n-th timestep of each camera, with another first one for the next
/// camera, so that cameras side by side complete each other. `turn`: 0, 1, 2, … take other frames
/// each, until all were taken.
SampledViews views_of_training(const Scene& scene, int64_t enough, int64_t turn = 0);

/// [N] static set first, in the backend's memory: T·α over all pixels of the views, drawn as
/// `forward` states, `batch` at a time. Of a Gaussian without a splat in any of them 0 where they
/// are all, else −1: it is not known.
Buffer<float> largest_weights(Backend& backend, Pipeline<float>& pipeline,
                              ForwardArgs<float> forward, const SampledViews& sampled,
                              int64_t batch);

/// Removes the Gaussians for which `keeps(set, element)` is false from those sets of the state that
/// are trained.
std::array<DensityReport, 2> prune_where_not(Backend& backend, TrainState& state,
                                             const std::function<bool(int, int64_t)>& keeps);

/// Removes the Gaussians whose largest weight is below `least`, from both sets of the state.
/// `largest`: [N] static set first; a Gaussian of which it is not known stays.
std::array<DensityReport, 2> prune_unseen(Backend& backend, const Buffer<float>& largest,
                                          double least, TrainState& state);

}  // namespace tessera
