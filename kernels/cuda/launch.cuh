// Launches of linear kernels with one thread for each element, the grid of kernels over the pixels
// of views, and the errors of CUDA statements as DeviceError.
#pragma once
#include <cuda_runtime.h>

#include <cstdint>
#include <string>
#include <utility>

#include "kernels/batch.h"

namespace tessera {

/// Throws DeviceError unless `code` is success; `what` names the statement and its sizes.
void check_device(cudaError_t code, const char* what);
/// After a launch: its configuration was accepted. Faults inside show up at the next wait.
inline void check_launch(const char* kernel) {
  check_device(cudaGetLastError(), kernel);
}

/// Blocks of `threads` that cover `count` items. Errors: DeviceError when there are too many.
unsigned grid_of(int64_t count, int threads);

/// The element of this thread; those behind the last one return at once.
__device__ inline int64_t linear_index() {
  return int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
}

/// kernel(arguments…) with a thread for each of `count` elements, in blocks of `Threads`; nothing
/// for none. Errors: DeviceError naming `what`.
template <int Threads, class... Parameters, class... Arguments>
void launch_linear(cudaStream_t stream, const char* what, void (*kernel)(Parameters...),
                   int64_t count, Arguments&&... arguments) {
  if (count <= 0) return;
  kernel<<<grid_of(count, Threads), Threads, 0, stream>>>(std::forward<Arguments>(arguments)...);
  check_launch(what);
}

/// One thread a pixel of the largest view, one row of blocks a view.
inline dim3 grid_of_views(const ViewBatch<float>& batch, int threads) {
  int64_t most = 0;
  for (const ViewArgs<float>& view : batch.views)
    most = max_of(most, int64_t(view.width) * view.height);
  return dim3(grid_of(most, threads), unsigned(batch.views.size()));
}

}  // namespace tessera
