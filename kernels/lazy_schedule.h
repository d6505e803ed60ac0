// What: the table behind the closed form of Adam steps without a gradient (math/lazy_adam.h).
// Not: learning rates: the table is for a rate of 1.
// Source: method G.3.
#pragma once
#include <cstdint>
#include <vector>

namespace tessera {

/// F[t] = Σ_{s≥1} c(t+s)·ρ^s for t = 0 … steps, c(t) = √(1−β2^t)/(1−β1^t), ρ = β1/√β2; then the
/// k steps after t0 weigh W = F[t0] − ρ^k·F[t0+k].  [steps + 1]
std::vector<double> lazy_adam_table(int64_t steps);

}  // namespace tessera
