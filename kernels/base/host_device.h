// Macros that let an equation be compiled for host and device. The backend itself is chosen at link
// time (backend.h).
#pragma once

// TESSERA_UNROLL: before a short loop over an array that must stay in registers.

#if defined(__CUDACC__)
#include <cuda.h>
#define TESSERA_HD __host__ __device__
#define TESSERA_UNROLL _Pragma("unroll")
#ifndef GLM_FORCE_CUDA
#define GLM_FORCE_CUDA
#endif
#else
#define TESSERA_HD
#define TESSERA_UNROLL
#endif
