// What: the macros that let an equation be compiled for host and device.
// Not: anything that selects a backend; backends are chosen at link time (backend.h).
#pragma once

// TESSERA_ONE_COPY: for a function whose calls must all round alike. Inlined into different loops,
// the same products may be contracted to different fused multiply-adds.

#if defined(__CUDACC__)
#include <cuda.h>
#define TESSERA_HD __host__ __device__
#define TESSERA_ONE_COPY __noinline__
#ifndef GLM_FORCE_CUDA
#define GLM_FORCE_CUDA
#endif
#else
#define TESSERA_HD
#define TESSERA_ONE_COPY [[gnu::noinline, gnu::noclone]]
#endif
