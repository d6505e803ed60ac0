// What: CUDA's return codes → DeviceError that names the statement and the free memory.
// Not: recovery; an out-of-memory error leaves the backend usable, others may not.
#pragma once
#include <cuda_runtime.h>

#include <cstdint>
#include <string>

namespace tessera {

/// Throws DeviceError unless `code` is success; `what` names the statement and its sizes.
void check_device(cudaError_t code, const char* what);
/// After a launch: its configuration was accepted. Faults inside show up at the next wait.
inline void check_launch(const char* kernel) {
  check_device(cudaGetLastError(), kernel);
}

/// Blocks of `threads` that cover `count` items. Errors: DeviceError when there are too many.
unsigned grid_of(int64_t count, int threads);

}  // namespace tessera
