// Images of a model with its candidates turned static, compared with those of the model as it is.
#include "recon4d/reduction/static_demotion.h"

#include <utility>

#include "recon4d/evaluation/render.h"
#include "recon4d/model/element_edits.h"
#include "recon4d/reduction/contributions.h"
#include "recon4d/reduction/motion_choice.h"

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

/// Candidates are the last elements of the trial's static set. Both models are drawn batch by
/// batch: nothing is kept of a frame.
Added added_error(Backend& backend, const GaussianModel& model, const GaussianModel& trial,
                  int64_t candidates, const FrameSample& sample) {
  ScoringPass before(backend, model, false), after(backend, trial, true);
  ElementBuffers elements(backend, trial, false);
  double total = 0;  // of what was drawn
  const double share = draw_sample(sample, kSampledFrames, [&](int64_t begin, int64_t end) {
    before.draw(sample, begin, end);
    after.draw_frames_of(before);
    total += after.squared_error() - before.squared_error();
    after.compare(before);
    after.add_to(elements);
  });
  Buffer<ElementSums<float>> sums;
  sums.copy_from(elements.sums);
  const int64_t first = trial.static_set.count() - candidates;
  Added added{{}, total / share};
  for (int64_t i = 0; i < candidates; ++i)
    added.error.push_back(double(sums[first + i].image[0]) / share);
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
  GaussianSet demoted(SetForm::kStatic, from.coefficients, memory);
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
  constexpr float kMostMoving = 0.25f;  // of its light lies in pixels that may move
  const SetContributions& dynamic = contributions.sets[1];
  DemotionVerdict verdict;
  for (size_t n = 0; n < dynamic.weight.size(); ++n)
    if (dynamic.weight[n] > 0 &&
        (!contributions.motion_known || dynamic.moving[n] <= kMostMoving * dynamic.weight[n]))
      verdict.accepted.push_back(int64_t(n));
  verdict.finished = verdict.accepted.empty();
  const GaussianSet demoted = as_static(backend, model, dynamic);
  for (int round = 0; round < rounds && !verdict.finished; ++round) {
    const GaussianSet candidates = taken_elements(backend, demoted, verdict.accepted);
    const Added added =
        added_error(backend, model, tried(backend, model, candidates, verdict.accepted),
                    candidates.count(), sample);
    verdict = judge({verdict.accepted, added.error, added.total, allowed, round + 1 == rounds});
  }
  DemotionTrial trial(backend.memory());
  trial.demoted = taken_elements(backend, demoted, verdict.accepted);
  trial.elements = std::move(verdict.accepted);
  trial.error = verdict.error;
  return trial;
}

}  // namespace tessera
