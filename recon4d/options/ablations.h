// What: each technique taken out of the full method, and each added alone to a basis without any.
// Not: presets of a training: an ablation goes on top of any of them.
#pragma once
#include <string>
#include <vector>

#include "recon4d/options/train_options.h"

namespace tessera {

using Ablation = NamedOptions;
const std::vector<Ablation>& ablations();

/// Errors: InputError naming the nearest known name.
void apply_ablation(TrainOptions& options, const std::string& name);

}  // namespace tessera
