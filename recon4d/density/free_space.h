// Space that is known to be empty: in the view of a training camera, nearer than anything that it
// sees. What lies there is drawn by no view of that camera, as it is nearer than its near plane, or
// it hides what the camera sees; other cameras put haze there, which views between them show.
#pragma once
#include <array>
#include <vector>

#include "kernels/backend.h"
#include "recon4d/density/density.h"
#include "recon4d/model/train_state.h"

namespace tessera {

/// Removes the Gaussians whose mean lies in the view of one of the cameras at a depth below
/// `distance`, world units, from both sets of the state.
std::array<DensityReport, 2> prune_free_space(Backend& backend, const std::vector<Camera>& cameras,
                                              double distance, TrainState& state);

}  // namespace tessera
