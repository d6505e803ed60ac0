// What: which dynamic Gaussians are to move alike: neighbours in space, and how much each pair
// counts. Not: the gradient (kernels/stages/regulariser.h), nor when lists are made (trainer.cpp).
// Source: method D.8  [Yang24]: Σ_i Σ_{j near i} w_ij ‖v_i − v_j‖/(k·N), k = 20.
// Deviation: w_ij = exp(−d²/2h²) with h the mean distance of neighbours, for exp(−100·d), which
// depends on the unit of the world.
#pragma once
#include <glm/vec3.hpp>
#include <vector>

#include "kernels/base/buffer.h"
#include "kernels/gaussians.h"

namespace tessera {

/// MotionPairs that own what they show.
struct RigidityLists {
  explicit RigidityLists(Memory& memory = host_memory())
      : first(memory), other(memory), affinity(memory) {}

  Buffer<int64_t> first;
  Buffer<int32_t> other;
  Buffer<float> affinity;

  MotionPairs<float> pairs() const { return {first.span(), other.span(), affinity.span()}; }
};

/// Lists in `memory` from the means of a set (world units, each at its own moment). Means that are
/// not finite have no neighbours.
RigidityLists rigidity_lists(const std::vector<glm::vec3>& means, Memory& memory);

}  // namespace tessera
