// Transfer of the gradients of a block's Gaussians into a sink (gradient_sink.h).
#pragma once
#include "kernels/stages/gradient_sink.h"

namespace tessera {

/// Scalar i of a group, counted through the set, into a sink.
__device__ inline void accept_scalar(const StoreGradient<float>& sink, Group group, int64_t i,
                                     float gradient) {
  sink.out.group[group].data[i] = gradient;
}
__device__ inline void accept_scalar(const ApplyAdam<float>& sink, Group group, int64_t i,
                                     float gradient) {
  adam_step(sink.adam.group[group], gradient, sink.value.group[group].data[i],
            sink.moment1.group[group].data[i], sink.moment2.group[group].data[i]);
}

/// The gradients of a block's Gaussians into the sink, group by group, whole lines at a time: a
/// thread with a Gaussian each would touch every line of memory once for each scalar of a group.
/// `on`: whether this thread's Gaussian takes a step.
template <SetForm form, int Threads, class Sink, class Gradient>
__device__ inline void accept_block(const Sink& sink, int64_t count, bool on,
                                    const Gradient& gradient, float* shared, bool* shared_on) {
  const int thread = int(threadIdx.x);
  const int64_t first = int64_t(blockIdx.x) * Threads;
  const int gaussians = int(min(count - first, int64_t{Threads}));
  shared_on[thread] = on;
  float* to = shared;
  Gradient::template for_each_group<form>(gradient, [&](Group, const float* g, int width) {
    for (int j = 0; j < width; ++j) to[thread * width + j] = g[j];
    to += Threads * width;
  });
  __syncthreads();
  const float* from = shared;
  Gradient::template for_each_group<form>(gradient, [&](Group group, const float*, int width) {
    TESSERA_UNROLL
    for (int j = 0; j < width; ++j) {
      const int i = j * Threads + thread;
      if (i < gaussians * width && shared_on[i / width])
        accept_scalar(sink, group, first * width + i, from[i]);
    }
    from += Threads * width;
  });
}

}  // namespace tessera
