// What: facts of this machine.
// Not: its CUDA devices (kernels/backend.h).
#pragma once
#include <cstdint>

namespace tessera {

/// Bytes of memory that programs can have in all.
int64_t machine_memory();

}  // namespace tessera
