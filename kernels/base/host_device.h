// What: the one macro that lets an equation be compiled for host and device.
// Not: anything that selects a backend; backends are chosen at link time (backend.h).
#pragma once

#if defined(__CUDACC__)
#include <cuda.h>
#define TESSERA_HD __host__ __device__
#ifndef GLM_FORCE_CUDA
#define GLM_FORCE_CUDA
#endif
#else
#define TESSERA_HD
#endif
