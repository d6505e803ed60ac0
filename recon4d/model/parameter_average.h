// The mean of the parameters over the last steps of a training, which is nearer to their optimum
// than the last step alone: the steps of Adam do not come to rest. Source: [Polyak92].
#pragma once
#include <cstdint>
#include <vector>

#include "kernels/backend.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

struct TrainState;

/// Part of a TrainState. Its Gaussians are those of the state, in their order: what changes either
/// begins the mean anew.
struct ParameterAverage {
  int64_t states = 0;                // of which it is the mean
  std::vector<Buffer<float>> means;  // of each of the averaged groups; empty where there are none

  void begin_anew();
  ParameterAverage clone_to(Memory& memory) const;
};

/// The groups of a state of which there is a mean: of the sets that train and of the motion nodes.
std::vector<ParameterGroup*> averaged_groups(TrainState& state);
std::vector<const ParameterGroup*> averaged_groups(const TrainState& state);

/// Adds what a state has now to its mean.
void add_to_average(Backend& backend, TrainState& state);
/// The mean becomes the values of the state, where there is one, and is forgotten.
void take_average(TrainState& state);

}  // namespace tessera
