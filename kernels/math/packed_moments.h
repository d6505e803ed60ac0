// What: Adam's two moments of a scalar in 32 bits, rounded at random, and the step on them.
// Not: which scalars keep them so (kernels/gaussians.h).
// Source: method A.4; stochastic rounding, so that moments follow steps smaller than their last
// bit.
#pragma once
#include <bit>
#include <cstdint>

#include "kernels/math/adam.h"

namespace tessera {

struct Moments {
  float m, v;
};

/// m with 8 bits of exponent and 7 of mantissa in the lower half of a word; in the upper one v,
/// which has no sign, with 8 and 8.
TESSERA_HD inline Moments unpacked_moments(uint32_t word) {
  return {std::bit_cast<float>(word << 16), std::bit_cast<float>(word >> 16 << 15)};
}

/// Each is rounded away from zero with the probability of what is cut off. `random`: 32 bits.
TESSERA_HD inline uint32_t packed_moments(const Moments& moments, uint32_t random) {
  const uint32_t m = (std::bit_cast<uint32_t>(moments.m) + (random & 0xFFFFu)) >> 16;
  const uint32_t v = (std::bit_cast<uint32_t>(moments.v) + (random >> 17)) >> 15;
  return v << 16 | m;
}

/// A bijection of 32 bits in which every bit of x changes about half of the result's.
TESSERA_HD inline uint32_t scrambled(uint32_t x) {
  x = (x ^ x >> 16) * 0x7FEB352Du;
  x = (x ^ x >> 15) * 0x846CA68Bu;
  return x ^ x >> 16;
}

/// adam_step of a scalar whose moments are packed in the bits of `word`. The rounding is that of
/// the step, the value and the gradient, wherever the scalar is stored: a set in another order
/// takes the same steps.
TESSERA_HD inline void adam_step_packed(const AdamScalars<float>& a, float gradient, float& value,
                                        float& word) {
  // +0 for both zeros
  const uint32_t seed = std::bit_cast<uint32_t>(value) * 0x9E3779B9u +
                        std::bit_cast<uint32_t>(gradient + 0.0f) + a.noise;
  Moments moments = unpacked_moments(std::bit_cast<uint32_t>(word));
  adam_step(a, gradient, value, moments.m, moments.v);
  word = std::bit_cast<float>(packed_moments(moments, scrambled(seed)));
}

}  // namespace tessera
