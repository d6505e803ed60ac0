// Relocation and growth of both sets: the backend chooses the elements and computes their copies.
#include "recon4d/density/mcmc.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// One draw for the dead of a set, or for elements that are added to it.
RelocationElements relocate(Backend& backend, const RelocationRule& rule, GaussianSet& set) {
  RelocationElements elements(backend.memory());
  backend.relocate_elements(set.values(), rule, elements);
  if (elements.moved > 0 || rule.added > 0)
    take_elements(backend, std::as_const(elements.values).span(),
                  std::as_const(elements.moments).span(), set);
  return elements;
}

}  // namespace

std::array<int64_t, 2> shares_of(int64_t total, const std::array<int64_t, 2>& weights) {
  const double all = double(weights[0]) + double(weights[1]);
  if (all == 0) return {0, 0};
  const int64_t first = std::llround(double(total) * (double(weights[0]) / all));
  return {first, total - first};
}

int64_t grown_count(int64_t count, double growth, int64_t limit) {
  const double grown = std::min(std::floor(growth * double(count)), double(limit));
  return std::max(count, int64_t(grown));
}

std::array<DensityReport, 2> control_mcmc(Backend& backend, const TrainOptions& options,
                                          TrainState& state) {
  const StageTimer timer(backend.clock(), kDensity);
  constexpr double kNoneDead = -1;  // no Gaussian is dead at this opacity
  const uint64_t seed = uint64_t(options.seed) ^ uint64_t(state.iteration) << 20;
  const auto rule = [&](int k, double dead_opacity, int64_t added) {
    return RelocationRule{dead_opacity, options.prune_opacity, added, seed ^ uint64_t(k) << 62};
  };
  std::array<DensityReport, 2> reports;
  std::array<int64_t, 2> weights{};
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    reports[size_t(k)].before = set.count();
    const RelocationElements elements = relocate(backend, rule(k, options.prune_opacity, 0), set);
    reports[size_t(k)].relocated = elements.moved;
    weights[size_t(k)] = elements.weight;
  }
  const int64_t count = state.model.count();
  if (count > 0 && weights[0] + weights[1] == 0)
    throw NumericalError(
        fmt::format("step {}: all Gaussians are fainter than prune_opacity {}; start with more "
                    "opaque ones (--init-opacity 0.5) or lower opacity_weight or mcmc_noise",
                    state.iteration, options.prune_opacity));
  const std::array<int64_t, 2> shares =
      shares_of(grown_count(count, options.mcmc_growth, growth_limit(options)) - count, weights);
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    DensityReport& report = reports[size_t(k)];
    report.added = shares[size_t(k)];
    if (report.added > 0) relocate(backend, rule(k, kNoneDead, report.added), set);
    report.after = set.count();
    state.statistics[k].reset(backend, set.count());
  }
  return reports;
}

}  // namespace tessera
