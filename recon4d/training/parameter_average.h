// The mean of the parameters over the last steps of a training, which is nearer to their optimum
// than the last step alone: the steps of Adam do not come to rest. Source: [Polyak92].
#pragma once
#include <cstdint>
#include <vector>

#include "kernels/backend.h"
#include "recon4d/model/train_state.h"

namespace tessera {

/// Of the values of both sets and of the motion nodes.
class ParameterAverage {
 public:
  explicit ParameterAverage(Backend& backend) : backend_(backend) {}

  /// Adds what the state has now; its Gaussians are those of the states before.
  void add(const TrainState& state);
  /// The mean becomes the values of the state, where there is one; forgets it.
  void take_place(TrainState& state);
  /// Forgets what was added: Gaussians are others, or in another order.
  void begin_anew();
  int64_t states() const { return states_; }

 private:
  Backend& backend_;
  std::vector<Buffer<float>> means_;  // of each group of values, as they come
  int64_t states_ = 0;
};

}  // namespace tessera
