// What: sums over the lanes of a warp.
// Not: what is summed.
#pragma once
#include <cstdint>

#include "kernels/base/host_device.h"

namespace tessera {

/// Of two values the second in lanes whose number has `Bit`, else the first. In assembly, for which
/// all bits of a lane become predicates in one instruction; left to itself the compiler takes three
/// for each.
template <int Bit>
__device__ inline float by_bit(int lane, float first, float second) {
  float chosen;
  asm("{\n\t"
      ".reg .pred has;\n\t"
      ".reg .b32 bit;\n\t"
      "and.b32 bit, %3, %4;\n\t"
      "setp.ne.b32 has, bit, 0;\n\t"
      "selp.f32 %0, %2, %1, has;\n\t"
      "}"
      : "=f"(chosen)
      : "f"(first), "f"(second), "r"(lane), "n"(Bit));
  return chosen;
}

/// The value that by_bit keeps, with what the lane that differs by `Bit` had of it.
template <int Bit>
__device__ inline float exchange(int lane, float first, float second) {
  return by_bit<Bit>(lane, first, second) +
         __shfl_xor_sync(~0u, by_bit<Bit>(lane, second, first), Bit);
}

/// Sums up to eight values over a warp: lane l ends with the total of value l / 4.
template <int Terms>
__device__ inline float reduce_eight(const float (&v)[Terms]) {
  static_assert(Terms >= 4 && Terms <= 8);
  const int lane = int(threadIdx.x) % 32;
  float w[4];
  TESSERA_UNROLL
  for (int k = 0; k < 4; ++k) w[k] = exchange<16>(lane, v[k], k + 4 < Terms ? v[k + 4] : 0.0f);
  const float u0 = exchange<8>(lane, w[0], w[2]), u1 = exchange<8>(lane, w[1], w[3]);
  float sum = exchange<4>(lane, u0, u1);
  sum += __shfl_xor_sync(~0u, sum, 2);
  return sum + __shfl_xor_sync(~0u, sum, 1);
}

/// In every lane.
__device__ inline int32_t largest_of_warp(int32_t v) {
  TESSERA_UNROLL
  for (int step = 16; step > 0; step /= 2) v = max(v, __shfl_xor_sync(~0u, v, step));
  return v;
}

}  // namespace tessera
