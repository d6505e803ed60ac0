// What: a scoring pass over batches of frames in the order of their timesteps, and what its sums
// say. Not: the sums (kernels/stages/contribution, kernels/stages/sensitivity).
#include "recon4d/reduction/contributions.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

constexpr int64_t kBatch = 4;  // frames drawn at once

int64_t counted_samples(const Frame& frame) {
  const std::vector<uint8_t>& mask = frame.mask.data;
  if (mask.empty()) return int64_t(frame.image.data.size());
  return 3 * int64_t(std::count_if(mask.begin(), mask.end(), [](uint8_t m) { return m != 0; }));
}

/// Mean square of gain − 1 over images and channels.
double gain_variance(const std::vector<Vec3<double>>& gains) {
  double sum = 0;
  for (const Vec3<double>& gain : gains) sum += dot(gain - 1.0, gain - 1.0) / 3;
  return gains.empty() ? 0 : sum / double(gains.size());
}

/// The sums of set k, [N] from `first` on, as they are asked for.
void read_sums(const Buffer<ElementSums<float>>& sums, int64_t first, SetContributions& set) {
  for (size_t n = 0; n < set.weight.size(); ++n) {
    const ElementSums<float>& sum = sums[first + int64_t(n)];
    const float light = std::max(sum.weight, 1e-12f);
    set.weight[n] = sum.weight;
    set.removal1[n] = sum.removal1;
    set.removal2[n] = sum.removal2;
    set.mean_time[n] = sum.time / light;
    set.opacity[n] = sum.opacity / light;
    std::copy_n(sum.truncation, kMaxShDegree, set.truncation_error[n].begin());
  }
}

SetContributions::Change change_of(const TimeVariation& v) {
  SetContributions::Change change;
  change.gain = float(varying_gain(v));
  change.timesteps = v.timesteps;
  change.light = float(v.light);
  change.peak_time = v.peak_time;
  change.peak_gain = float(v.peak_gain);
  // as long as if every timestep had the gain of the best
  change.lasting = v.peak_gain > 0 ? float(v.gain / v.peak_gain) : 0;
  change.colour = Vec3<float>(v.colour);
  return change;
}

}  // namespace

void SetContributions::resize(int64_t count) {
  for (std::vector<float>* values : {&weight, &removal1, &removal2, &mean_time, &opacity})
    values->assign(size_t(count), 0.0f);
  truncation_error.assign(size_t(count), {});
  change.assign(size_t(count), {});
}

double Contributions::psnr_after(double added) const {
  return 10 *
         std::log10(double(std::max<int64_t>(1, samples)) / std::max(1e-12, squared_error + added));
}

Contributions measure_contributions(Backend& backend, const GaussianModel& model,
                                    const FrameSample& sample) {
  Contributions contributions;
  contributions.gain_variance = gain_variance(sample.gain);
  ElementBuffers elements(backend, model);
  ScoringPass pass(backend, model);
  const auto time = [&](int64_t i) {
    return sample.scene->frames[size_t(sample.frames[size_t(i)])].time;
  };
  for (int64_t begin = 0; begin < sample.count();) {
    int64_t end = begin + 1;  // a batch has one timestep
    while (end < std::min(begin + kBatch, sample.count()) && time(end) == time(begin)) ++end;
    pass.draw(sample, begin, end);
    contributions.squared_error += pass.squared_error();
    for (int64_t i = begin; i < end; ++i)
      contributions.samples +=
          counted_samples(sample.scene->frames[size_t(sample.frames[size_t(i)])]);
    pass.add_to(elements);
    if (end == sample.count() || time(end) != time(begin))
      backend.close_timestep(time(begin), elements.variation.span());
    begin = end;
  }
  Buffer<ElementSums<float>> sums;
  sums.copy_from(elements.sums);
  Buffer<TimeVariation> variation;
  variation.copy_from(elements.variation);
  int64_t first = 0;
  for (int k = 0; k < 2; ++k) {
    const int64_t count = (k == 0 ? model.static_set : model.dynamic_set).count();
    contributions.sets[k].resize(count);
    read_sums(sums, first, contributions.sets[k]);
    first += count;
  }
  for (int64_t n = 0; n < variation.size(); ++n)
    contributions.sets[0].change[size_t(n)] = change_of(variation[n]);
  return contributions;
}

}  // namespace tessera
