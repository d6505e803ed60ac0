// What: what training gathers of each Gaussian beside its parameters.
// Not: the parameters (gaussian_set.h).
#pragma once
#include "kernels/backend.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// What a set has gathered since the last density control, and how far its colours have come.
struct SetStatistics {
  explicit SetStatistics(Memory& memory = host_memory())
      : gradient_sum(memory), count(memory), sh_step(memory), filter_size(memory), anchor(memory) {}

  Buffer<float> gradient_sum, count;  // [N] as DensityStatistics
  Buffer<int32_t> sh_step;            // [N] as LazySh::last_step; used where SH may be behind
  /// [N] φ of the 3D filter, world units; empty: there is none, or it is to be measured.
  Buffer<float> filter_size;
  /// [N, 3] the means from which neighbours were last told, world units; empty: there are none, or
  /// they are to be found.
  Buffer<float> anchor;

  /// Nothing gathered or measured, all colours at `step`. The first is for the host's memory.
  void reset(int64_t gaussians, int64_t step = 0);
  void reset(Backend& backend, int64_t gaussians, int64_t step);
  SetStatistics clone_to(Memory& memory) const;
  DensityStatistics<float> spans() { return {gradient_sum.span(), count.span()}; }
  DensityStatistics<const float> spans() const { return {gradient_sum.span(), count.span()}; }
};

}  // namespace tessera
