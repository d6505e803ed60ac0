// What: the table behind the closed form of Adam steps without a gradient.
// Not: its use (math/lazy_adam.h).
// Source: method G.3.
#include "kernels/lazy_schedule.h"

#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/math/lazy_adam.h"

namespace tessera {
namespace {

constexpr int64_t kTail = 600;  // ρ^600 < 1e-27: what comes after does not show in a double

/// √(1−β2^t)/(1−β1^t), without cancellation where t is small.
double bias_correction(int64_t step) {
  return std::sqrt(-std::expm1(double(step) * std::log(kAdamBeta2))) /
         -std::expm1(double(step) * std::log(kAdamBeta1));
}

}  // namespace

std::vector<double> lazy_adam_table(int64_t steps) {
  check(steps >= 0, "lazy Adam: a table of fewer than no steps");
  const double rho = kAdamBeta1 / std::sqrt(kAdamBeta2);
  std::vector<double> table(size_t(steps) + 1);
  double sum = 0;
  for (int64_t t = steps + kTail; t >= 0; --t) {
    sum = rho * (bias_correction(t + 1) + sum);  // F[t] = ρ·(c(t+1) + F[t+1])
    if (t <= steps) table[size_t(t)] = sum;
  }
  return table;
}

}  // namespace tessera
