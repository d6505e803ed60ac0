// What: k Adam steps with a zero gradient at once.
// Not: the table behind it (kernels/lazy_schedule.h).
// Source: method G.3.
#pragma once
#include "kernels/math/adam.h"

namespace tessera {

template <class Real>
struct LazyGap {
  Real w, decay1, decay2, epsilon;
};

template <class Real>
TESSERA_HD inline LazyGap<Real> lazy_gap(const double* table, int64_t last_step, int64_t step) {
  const double k = double(step - last_step);
  const double log2_beta1 = std::log2(kAdamBeta1), log2_beta2 = std::log2(kAdamBeta2);
  const double rho = exp2(k * (log2_beta1 - 0.5 * log2_beta2));
  return {Real(table[last_step] - rho * table[step]), Real(exp2(k * log2_beta1)),
          Real(exp2(k * log2_beta2)),
          Real(kAdamEpsilon * sqrt(1 - exp2(double(last_step) * log2_beta2)))};
}

template <class Real>
TESSERA_HD inline void lazy_catch_up(const LazyGap<Real>& gap, Real learning_rate, Real& value,
                                     Real& m, Real& v) {
  if (m == Real(0)) return;
  value -= learning_rate * gap.w * m / (sqrt(v) + gap.epsilon);
  m *= gap.decay1, v *= gap.decay2;
}

}  // namespace tessera
