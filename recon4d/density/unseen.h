// Pruning of Gaussians that no training view shows: the largest blending weight of each Gaussian
// over all pixels of the views, and the removal of those below a threshold. They cost memory and
// appear from other directions, where no image constrains them.
#pragma once
#include <array>
#include <vector>

#include "kernels/pipeline.h"
#include "recon4d/density/density.h"
#include "recon4d/model/train_state.h"

namespace tessera {

/// Views that may show a Gaussian of either set: those of all training frames, in the order of a
/// frame sample, or of so many sweeps as have `enough` frames.
std::vector<View> views_of_training(const Scene& scene, int64_t enough);

/// [N] static set first, in the backend's memory: T·α over all pixels of `views`, drawn as
/// `forward` states, `batch` at a time.
Buffer<float> largest_weights(Backend& backend, Pipeline<float>& pipeline,
                              ForwardArgs<float> forward, const std::vector<View>& views,
                              int64_t batch);

/// Removes the Gaussians whose largest weight is below `least`, from both sets of the state.
/// `largest`: [N] static set first.
std::array<DensityReport, 2> prune_unseen(Backend& backend, const Buffer<float>& largest,
                                          double least, TrainState& state);

}  // namespace tessera
