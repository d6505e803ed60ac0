// What: what training gathers of each Gaussian beside its parameters.
// Not: the parameters (gaussian_set.h).
#pragma once
#include "kernels/backend.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// What a set has gathered since the last density control.
struct SetStatistics {
  explicit SetStatistics(Memory& memory = host_memory())
      : gradient_sum(memory), count(memory), filter_size(memory) {}

  Buffer<float> gradient_sum, count;  // [N] as DensityStatistics
  /// [N] φ of the 3D filter, world units; empty: there is none, or it is to be measured.
  Buffer<float> filter_size;

  /// Nothing gathered or measured. The first is for the host's memory.
  void reset(int64_t gaussians);
  void reset(Backend& backend, int64_t gaussians);
  SetStatistics clone_to(Memory& memory) const;
  DensityStatistics<float> spans() { return {gradient_sum.span(), count.span()}; }
  DensityStatistics<const float> spans() const { return {gradient_sum.span(), count.span()}; }
};

}  // namespace tessera
