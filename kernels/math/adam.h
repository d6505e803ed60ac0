// One Adam step of one scalar, with float moments or with both moments packed in one 32-bit word.
// Source: [Kingma15] in PyTorch's form, method A.4.
#pragma once
#include <bit>
#include <cstdint>

#include "kernels/math/scalar.h"

namespace tessera {

/// Adam for one parameter group at one step t ≥ 1, bias corrections folded in by the host.
template <class Real>
struct AdamScalars {
  Real beta1, beta2;
  Real step_size;  // η/(1−β1^t)
  Real v_scale;    // 1/√(1−β2^t)
  Real epsilon;
  uint32_t noise;  // differs from step to step (adam_step_packed)
};

inline constexpr double kAdamBeta1 = 0.9, kAdamBeta2 = 0.999, kAdamEpsilon = 1e-15;

template <class Real>
AdamScalars<Real> adam_scalars(double learning_rate, int64_t step) {
  return {Real(kAdamBeta1),
          Real(kAdamBeta2),
          Real(learning_rate / (1 - std::pow(kAdamBeta1, double(step)))),
          Real(1 / std::sqrt(1 - std::pow(kAdamBeta2, double(step)))),
          Real(kAdamEpsilon),
          uint32_t(step) * 0x85EBCA6Bu};
}

/// θ ← θ − [η/(1−β1^t)]·m / (√v/√(1−β2^t) + ε).
template <class Real>
TESSERA_HD inline void adam_step(const AdamScalars<Real>& a, Real gradient, Real& value, Real& m,
                                 Real& v) {
  m = a.beta1 * m + (Real(1) - a.beta1) * gradient;
  v = a.beta2 * v + (Real(1) - a.beta2) * gradient * gradient;
  value -= fast_divide(a.step_size * m, fast_sqrt(v) * a.v_scale + a.epsilon);
}

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
