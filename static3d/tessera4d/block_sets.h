// Blocks of a Tessera 4D file decoded and joined to the sets of a model.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "static3d/tessera4d/container.h"

namespace tessera {

/// A model of the blocks that are `wanted`, with the rules and the clock of the clip; its dynamic
/// set is in velocity form. `warnings` gets what was left out. Errors: InputError naming the file,
/// what is wrong, the remedy.
GaussianModel model_of_blocks(const Tessera4dContainer& container,
                              const std::function<bool(const BlockInfo&)>& wanted,
                              std::vector<std::string>& warnings);

/// A model of no Gaussians that is drawn as `model` is.
GaussianModel rules_of(const GaussianModel& model, const TimeAxis& clock);

}  // namespace tessera
