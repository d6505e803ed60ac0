// What: the table from which idle Adam steps are summed in closed form.
// Not: the steps (math/lazy_adam.h).
// Source: method G.3.
#pragma once
#include <cstdint>
#include <vector>

namespace tessera {

/// F[t] = ρ·(c(t+1) + F[t+1]) for t = 0 … steps, with ρ = β1/√β2 and c(t) = √(1−β2^t)/(1−β1^t).
std::vector<double> lazy_adam_table(int64_t steps);

}  // namespace tessera
