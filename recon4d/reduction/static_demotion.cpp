// What: a model with candidates turned static beside the model as it is, image by image.
// Not: sums over pixels (kernels/stages/sensitivity).
#include "recon4d/reduction/static_demotion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/base/parallel.h"
#include "kernels/elements/load_gaussian.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/sh_blocks.h"
#include "recon4d/model/shape3.h"

namespace tessera {
namespace {

constexpr int64_t kGaussianGrain = 2048;  // per task

template <Form form>
void place_still(const GaussianSpans<const float>& from, const ColourRules<float>& colours,
                 int64_t n, float timestep, float opacity, const GaussianSpans<float>& to) {
  std::copy_n(from.at(kMean, n), 3, to.at(kMean, n));
  std::copy_n(from.at(kLogScale, n), 3, to.at(kLogScale, n));
  std::copy_n(from.at(kRotation, n), 4, to.at(kRotation, n));
  std::copy_n(from.at(kSh, n), from.width(kSh), to.at(kSh, n));
  *to.at(kOpacityLogit, n) = *from.at(kOpacityLogit, n);
  GaussianState<float> g;
  if (!(opacity > 0) || !load_gaussian<form>(from, n, g)) return;
  const Slice<float> slice = slice_at(g.mean, g.spacetime, timestep);
  float room[3 * kMaxShCoefficients];
  std::copy_n(sh_at(colours, g, slice.delta, room), colours.scalars(), to.at(kSh, n));
  const Sym3<float>& c = g.spacetime.covariance;
  const Shape3 shape = shape_of(Sym3<double>{c.xx, c.xy, c.xz, c.yy, c.yz, c.zz});
  for (int k = 0; k < 3; ++k) {
    to.at(kMean, n)[k] = slice.mean[k];
    to.at(kLogScale, n)[k] = float(shape.log_scale[k]);
  }
  for (int k = 0; k < 4; ++k) to.at(kRotation, n)[k] = float(shape.rotation[k]);
  *to.at(kOpacityLogit, n) = logit(std::clamp(opacity, 1e-4f, 1 - 1e-6f));
}

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

constexpr int64_t kBatch = 4;  // frames drawn at once

/// Squared error that a trial adds: in all, and each candidate's share by its light.
struct Added {
  std::vector<float> error;  // [candidates]
  double total = 0;
};

/// Candidates are the last elements of the trial's static set. Both models are drawn batch by
/// batch: nothing is kept of a frame.
Added added_error(Backend& backend, const GaussianModel& model, const GaussianModel& trial,
                  int64_t candidates, const FrameSample& sample) {
  Added added;
  ScoringPass before(backend, model), after(backend, trial);
  ElementBuffers elements(backend, trial);
  for (int64_t begin = 0; begin < sample.count(); begin += kBatch) {
    const int64_t end = std::min(begin + kBatch, sample.count());
    before.draw(sample, begin, end);
    after.draw_frames_of(before);
    added.total += after.squared_error() - before.squared_error();
    after.compare(before);
    after.add_to(elements);
  }
  Buffer<ElementSums<float>> sums;
  sums.copy_from(elements.sums);
  const int64_t first = trial.static_set.count() - candidates;
  for (int64_t i = 0; i < candidates; ++i) added.error.push_back(sums[first + i].image[0]);
  return added;
}

}  // namespace

GaussianSet as_static(const GaussianModel& model, const SetContributions& contributions) {
  const GaussianSet moving = model.dynamic_set.clone_values(host_memory());
  const GaussianSpans<const float> from = moving.values();
  GaussianSet still(Form::kStatic, from.coefficients);
  still.resize(from.count);
  const GaussianSpans<float> to = still.values();
  const ColourRules<float> colours =
      make_colour_rules<float>(render_options(model), from.coefficients, from.time_levels);
  parallel_for(from.count, kGaussianGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      const float timestep = contributions.mean_time[size_t(n)],
                  opacity = contributions.opacity[size_t(n)];
      from.form == Form::kPair
          ? place_still<Form::kPair>(from, colours, n, timestep, opacity, to)
          : place_still<Form::kVelocity>(from, colours, n, timestep, opacity, to);
    }
  });
  return still;
}

DemotionTrial try_demotion(Backend& backend, const GaussianModel& model,
                           const Contributions& contributions, const FrameSample& sample,
                           double allowed, int rounds) {
  DemotionTrial trial(backend.memory());
  const SetContributions& dynamic = contributions.sets[1];
  for (size_t n = 0; n < dynamic.weight.size(); ++n)
    if (dynamic.weight[n] > 0) trial.elements.push_back(int64_t(n));
  const GaussianSet still = as_static(model, dynamic).clone_values(backend.memory());
  for (int round = 0; round < rounds && !trial.elements.empty(); ++round) {
    const GaussianSet candidates = taken_elements(backend, still, trial.elements);
    const Added added =
        added_error(backend, model, tried(backend, model, candidates, trial.elements),
                    candidates.count(), sample);
    trial.error = added.total;
    std::vector<std::pair<float, int64_t>> accepted;
    for (size_t i = 0; i < trial.elements.size(); ++i) {
      if (added.error[i] <= allowed) accepted.emplace_back(added.error[i], trial.elements[i]);
    }
    // what nobody in particular adds counts too: then only the better half is tried again
    const bool together = added.total <= allowed * double(trial.elements.size());
    const bool all = accepted.size() == trial.elements.size();
    if (all && together) break;
    if (all) {
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
  }
  trial.demoted = taken_elements(backend, still, trial.elements);
  return trial;
}

}  // namespace tessera
