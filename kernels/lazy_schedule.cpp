// What: the recurrence, backward from far enough beyond the end that its start does not matter.
// Not: learning rates: they are constant, and factors of the sum.
#include "kernels/lazy_schedule.h"

#include <cmath>

#include "kernels/math/adam.h"

namespace tessera {

std::vector<double> lazy_adam_table(int64_t steps) {
  constexpr int64_t kBeyond = 1000;  // ρ^1000 = 3e-46
  const double rho = kAdamBeta1 / std::sqrt(kAdamBeta2);
  std::vector<double> table(static_cast<size_t>(steps + 1));
  double sum = 0;
  for (int64_t t = steps + kBeyond - 1; t >= 0; --t) {
    const double next = double(t + 1);
    const double c = std::sqrt(1 - std::pow(kAdamBeta2, next)) / (1 - std::pow(kAdamBeta1, next));
    sum = rho * (c + sum);
    if (t <= steps) table[size_t(t)] = sum;
  }
  return table;
}

}  // namespace tessera
