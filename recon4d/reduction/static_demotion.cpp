// What: a model with candidates turned static beside the model as it is, image by image.
// Not: sums over pixels (kernels/stages/sensitivity).
#include "recon4d/reduction/static_demotion.h"

#include <algorithm>
#include <utility>

#include "recon4d/evaluation/render.h"
#include "recon4d/model/sh_blocks.h"
#include "recon4d/reduction/precision.h"

namespace tessera {
namespace {

/// Static Gaussians of `model`, then `added`; dynamic ones but `without`. Where the backend works.
GaussianModel tried(Backend& backend, const GaussianModel& model, const GaussianSet& added,
                    const std::vector<int64_t>& without) {
  GaussianModel trial = model.clone_values(backend.memory());
  SetStatistics statistics(backend.memory()), of_added(backend.memory());
  statistics.reset(backend, trial.static_set.count());
  of_added.reset(backend, added.count());
  append_elements(backend, added, of_added, trial.static_set, statistics);
  SetStatistics none(backend.memory());
  keep_elements(backend, elements_but(model.dynamic_set.count(), without), trial.dynamic_set, none);
  return trial;
}

/// Squared error that a trial adds over all training frames: in all, and each candidate's share by
/// its light.
struct Added {
  std::vector<double> error;  // [candidates]
  double total = 0;
};

/// Candidates are the last elements of the trial's static set; `allowed`: as of try_demotion. Both
/// models are drawn batch by batch: nothing is kept of a frame.
Added added_error(Backend& backend, const GaussianModel& model, const GaussianModel& trial,
                  int64_t candidates, const FrameSample& sample, double allowed) {
  ScoringPass before(backend, model, false), after(backend, trial, true);
  ElementBuffers elements(backend, trial, false);
  double squared_error = 0, total = 0;  // of what was drawn
  const auto draw = [&](int64_t begin, int64_t end, int32_t series) {
    before.draw(sample, begin, end);
    after.draw_frames_of(before);
    const double error = before.squared_error();
    squared_error += error;
    total += after.squared_error() - error;
    after.compare(before);
    after.add_to(elements, series);
  };
  Buffer<ElementSums<float>> sums;
  const int64_t first = trial.static_set.count() - candidates;
  const auto so_far = [&](double share) {
    sums.copy_from(elements.sums);
    PricedErrors now;
    now.squared_error = squared_error;
    for (int64_t i = 0; i < candidates; ++i) now.error.push_back(double(sums[first + i].image[0]));
    now.price.assign(size_t(candidates), allowed * share);
    return now;
  };
  const double share = draw_until_precise(sample, draw, so_far);
  Added added{so_far(share).error, total / share};
  for (double& error : added.error) error /= share;
  return added;
}

}  // namespace

GaussianSet as_static(Backend& backend, const GaussianModel& model,
                      const SetContributions& contributions) {
  Memory& memory = backend.memory();
  const GaussianSet& dynamic = model.dynamic_set;
  const bool lies_here = &dynamic.memory() == &memory;
  const GaussianSet copied = lies_here ? dynamic.like() : dynamic.clone_values(memory);
  const GaussianSpans<const float> from = (lies_here ? dynamic : copied).values();
  GaussianSet demoted(Form::kStatic, from.coefficients, memory);
  demoted.resize(from.count);
  const auto brought = [&](const std::vector<float>& values) {
    Buffer<float> buffer(int64_t(values.size()), memory);
    memory.copy(buffer.data(), values.data(), sizeof(float) * values.size());
    return buffer;
  };
  const Buffer<float> timestep = brought(contributions.mean_time),
                      opacity = brought(contributions.opacity);
  backend.demote({from, render_options(model), timestep.span(), opacity.span(), demoted.values()});
  return demoted;
}

DemotionTrial try_demotion(Backend& backend, const GaussianModel& model,
                           const Contributions& contributions, const FrameSample& sample,
                           double allowed, int rounds) {
  // of 50 candidates: another round would change as few of the others' shares
  constexpr int64_t kFewRejected = 50;
  DemotionTrial trial(backend.memory());
  const SetContributions& dynamic = contributions.sets[1];
  for (size_t n = 0; n < dynamic.weight.size(); ++n)
    if (dynamic.weight[n] > 0) trial.elements.push_back(int64_t(n));
  const GaussianSet demoted = as_static(backend, model, dynamic);
  for (int round = 0; round < rounds && !trial.elements.empty(); ++round) {
    const GaussianSet candidates = taken_elements(backend, demoted, trial.elements);
    const Added added =
        added_error(backend, model, tried(backend, model, candidates, trial.elements),
                    candidates.count(), sample, allowed);
    trial.error = added.total;
    std::vector<std::pair<double, int64_t>> accepted;
    for (size_t i = 0; i < trial.elements.size(); ++i) {
      if (added.error[i] <= allowed) accepted.emplace_back(added.error[i], trial.elements[i]);
    }
    // what nobody in particular adds counts too: then only the better half is tried again
    const bool together = added.total <= allowed * double(trial.elements.size());
    const int64_t rejected = int64_t(trial.elements.size() - accepted.size());
    if (rejected == 0 && together) break;
    if (rejected == 0) {
      std::stable_sort(accepted.begin(), accepted.end());
      accepted.resize(accepted.size() / 2);
    }
    if (round + 1 == rounds && !together) accepted.clear();
    trial.elements.clear();
    trial.error = 0;
    for (const auto& [error, element] : accepted) {
      trial.elements.push_back(element);
      trial.error += error;
    }
    std::sort(trial.elements.begin(), trial.elements.end());
    if (together && rejected * kFewRejected <= int64_t(trial.elements.size())) break;
  }
  trial.demoted = taken_elements(backend, demoted, trial.elements);
  return trial;
}

}  // namespace tessera
