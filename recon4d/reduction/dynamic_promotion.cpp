// The test against noise, and the elements that are promoted or added.
#include "recon4d/reduction/dynamic_promotion.h"

#include <algorithm>
#include <cmath>

#include "kernels/math/splat.h"
#include "recon4d/model/element_edits.h"

namespace tessera {
namespace {

/// What χ² of so many degrees of freedom exceeds as rarely as a normal number exceeds `deviations`:
/// its cube root is nearly normal (Wilson and Hilferty, 1931).
double rare_chi_square(double freedom, double deviations) {
  const double variance = 2 / (9 * freedom);
  return freedom * std::pow(1 - variance + deviations * std::sqrt(variance), 3);
}

/// Elements of the static set in the form and layout of the dynamic one, at timestep 0; in the
/// host's memory.
GaussianSet at_rest(Backend& backend, const GaussianModel& model,
                    const std::vector<int64_t>& elements) {
  GaussianSet set = model.dynamic_set.like();
  set.resize(int64_t(elements.size()));
  const GaussianSet chosen =
      taken_elements(backend, model.static_set, elements).clone_values(host_memory());
  const GaussianSpans<const float> from = chosen.values();
  const GaussianSpans<float> to = set.values();
  for (int g = 0; g < set.groups(); ++g) std::fill_n(to.group[g].data, to.group[g].size, 0.0f);
  for (int64_t i = 0; i < set.count(); ++i) {
    for (const Group group : {kMean, kLogScale, kRotation, kOpacityLogit, kSh})
      std::copy_n(from.at(group, i), from.width(group), to.at(group, i));
    if (set.form() == SetForm::kPair)  // at rest: r = conj(l)
      for (int k = 0; k < 4; ++k)
        to.at(kRotationRight, i)[k] = (k == 0 ? 1.0f : -1.0f) * from.at(kRotation, i)[k];
  }
  return set;
}

}  // namespace

std::vector<int64_t> time_varying_elements(const Contributions& contributions, double least,
                                           int64_t most) {
  // under white noise of variance s² the gain is s² · χ² with three degrees of freedom for each
  // timestep of a series beyond its first
  constexpr double kDeviations = 5;
  constexpr float kLeastMoving = 0.1f;  // of its light lies in pixels that may move
  const double noise = contributions.squared_error / std::max(1.0, contributions.samples);
  std::vector<std::pair<float, int64_t>> found;
  const SetContributions& set = contributions.sets[0];
  const std::vector<SetContributions::Change>& change = set.change;
  for (size_t n = 0; n < change.size(); ++n) {
    const double freedom = 3 * double(change[n].freedom);
    if (freedom <= 0) continue;
    if (contributions.motion_known && !(set.moving[n] > kLeastMoving * set.weight[n])) continue;
    // and gains as large as those that images have, not found yet, change all of its light
    const double chance = noise * rare_chi_square(freedom, kDeviations) +
                          contributions.gain_variance * double(change[n].light);
    if (double(change[n].gain) > std::max(chance, least * contributions.share))
      found.emplace_back(-change[n].gain, n);
  }
  std::sort(found.begin(), found.end());
  if (int64_t(found.size()) > most) found.resize(size_t(std::max<int64_t>(0, most)));
  std::vector<int64_t> elements;
  elements.reserve(found.size());
  for (const auto& [gain, element] : found) elements.push_back(element);
  std::sort(elements.begin(), elements.end());
  return elements;
}

GaussianSet as_dynamic(Backend& backend, const GaussianModel& model,
                       const Contributions& contributions, const std::vector<int64_t>& elements) {
  constexpr float kLife = 1;  // clip lengths; at its ends 0.88 of the opacity is there, or more
  GaussianSet moving = at_rest(backend, model, elements);
  const GaussianSpans<float> to = moving.values();
  for (int64_t i = 0; i < moving.count(); ++i) {
    *to.at(kMeanTime, i) = contributions.sets[0].mean_time[size_t(elements[size_t(i)])];
    *to.at(kLogScaleTime, i) = std::log(kLife);
  }
  return moving;
}

GaussianSet spawn_dynamic(Backend& backend, const GaussianModel& model,
                          const Contributions& contributions,
                          const std::vector<int64_t>& elements) {
  constexpr float kOpacity = 0.5f;
  GaussianSet spawned = at_rest(backend, model, elements);
  const GaussianSpans<float> to = spawned.values();
  for (int64_t i = 0; i < spawned.count(); ++i) {
    const SetContributions::Change& change =
        contributions.sets[0].change[size_t(elements[size_t(i)])];
    *to.at(kOpacityLogit, i) = logit(kOpacity);
    // half of the light is to be what it should be
    for (int c = 0; c < 3; ++c)
      to.at(kSh, i)[c] += std::clamp(change.colour[c] / kOpacity, -0.5f, 0.5f) / float(kSh0);
    *to.at(kMeanTime, i) = change.peak_time;
    const float share = change.lasting / std::max(1.0f, change.timesteps);
    *to.at(kLogScaleTime, i) = std::log(std::clamp(0.5f * share, 0.02f, 0.5f));
  }
  return spawned;
}

}  // namespace tessera
