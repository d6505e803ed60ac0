// What: what k Adam steps without a gradient do to a scalar, in closed form, so that a Gaussian
// that no view sees need not be visited.
// Not: the step with a gradient (adam.h), the table (kernels/lazy_schedule.h). Not for scalars
// whose learning rate changes from step to step.
// Source: method G.3; the steps deferred are those of [Kingma15] in PyTorch's form.
#pragma once
#include "kernels/math/adam.h"

namespace tessera {

/// log₂ of β1 and β2 as adam_step holds them in Real. Rounded to float, 1 − β2 is off by 1.3e-5 of
/// itself, which the steps cancel with a decay by the same β2: an exact β2 here would leave it in
/// v.
template <class Real>
inline constexpr double kLog2Beta1 = -0.15200309344504996;
template <class Real>
inline constexpr double kLog2Beta2 = -0.0014434168696687174;
template <>
inline constexpr double kLog2Beta1<float> = -0.1520031316634173;
template <>
inline constexpr double kLog2Beta2<float> = -0.001443398276949825;
/// log₂ of ρ = β1/√β2, the ratio of two neighbouring steps without a gradient, as in the table.
inline constexpr double kLog2Rho = -0.15128138501021563;

/// k steps without a gradient after step t0, the same for all scalars of a Gaussian.
template <class Real>
struct LazyGap {
  Real w;        // Σ_{s=1..k} c(t0+s)·ρ^s, c(t) = √(1−β2^t)/(1−β1^t)
  Real decay1;   // β1^k
  Real decay2;   // β2^k
  Real epsilon;  // ε·√(1−β2^t0)
};

/// The gap from the last step that is applied (0: none yet, moments are zero) to `step` inclusive.
/// table: lazy_adam_table(steps), step ≤ steps. In double throughout: W is a difference, and
/// k·log₂β does not fit a float.
template <class Real>
TESSERA_HD inline LazyGap<Real> lazy_gap(const double* table, int64_t last_step, int64_t step) {
  if (last_step <= 0) return {Real(0), Real(1), Real(1), Real(kAdamEpsilon)};
  const double k = double(step - last_step);
  const double w = table[last_step] - std::exp2(kLog2Rho * k) * table[step];
  const double correction = std::sqrt(1 - std::exp2(kLog2Beta2<double> * double(last_step)));
  return {Real(w), Real(std::exp2(kLog2Beta1<Real> * k)), Real(std::exp2(kLog2Beta2<Real> * k)),
          Real(kAdamEpsilon * correction)};
}

/// θ after the gap: θ − η·W·m / (√v + ε√(1−β2^t0)). Exact but for ε, which the steps weigh against
/// a √v that decays: W is off by (0.505 % + 5/t0)·e/(1+e) of itself at most, e = ε√(1−β2^t0)/√v.
template <class Real>
TESSERA_HD inline Real lazy_value(const LazyGap<Real>& gap, Real learning_rate, Real value, Real m,
                                  Real v) {
  return value - learning_rate * gap.w * (m / (sqrt(v) + gap.epsilon));
}

/// Value and moments after the gap.
template <class Real>
TESSERA_HD inline void lazy_catch_up(const LazyGap<Real>& gap, Real learning_rate, Real& value,
                                     Real& m, Real& v) {
  value = lazy_value(gap, learning_rate, value, m, v);
  m *= gap.decay1;
  v *= gap.decay2;
}

}  // namespace tessera
