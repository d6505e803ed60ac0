// What: one Adam step of one scalar.
// Not: which scalars take it: the gradient sink decides (stages/gradient_sink.h).
// Source: [Kingma15] in PyTorch's form, method A.4.
#pragma once
#include "kernels/math/scalar.h"

namespace tessera {

/// Adam for one parameter group at one step t ≥ 1, bias corrections folded in by the host.
template <class Real>
struct AdamScalars {
  Real beta1, beta2;
  Real step_size;  // η/(1−β1^t)
  Real v_scale;    // 1/√(1−β2^t)
  Real epsilon;
  uint32_t noise;  // differs from step to step (packed_moments.h)
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

}  // namespace tessera
