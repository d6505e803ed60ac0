// What: the SH coefficients of one Gaussian in one thread's registers.
// Not: the colour (math/spherical_harmonics.h).
#pragma once
#include "kernels/math/spherical_harmonics.h"

namespace tessera {

/// SH coefficients in registers, sixteen bytes at a time where rows allow it.
__device__ inline void load_sh(const float* from, int row, int wanted, float* sh) {
  if (row % 4 == 0) {
    TESSERA_UNROLL
    for (int j = 0; j < 3 * kMaxShCoefficients; j += 4) {
      if (j >= wanted) break;
      const float4 four = *reinterpret_cast<const float4*>(from + j);
      sh[j] = four.x, sh[j + 1] = four.y, sh[j + 2] = four.z, sh[j + 3] = four.w;
    }
  } else {
    TESSERA_UNROLL
    for (int j = 0; j < 3 * kMaxShCoefficients; ++j)
      if (j < wanted) sh[j] = from[j];
  }
}

}  // namespace tessera
