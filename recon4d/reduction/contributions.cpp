// A scoring pass over batches of frames in the order of their timesteps, and the contributions from
// its sums.
#include "recon4d/reduction/contributions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

namespace tessera {
namespace {

int64_t counted_samples(const Frame& frame) {
  const std::vector<uint8_t>& mask = frame.mask.data();
  if (mask.empty()) return int64_t(frame.image.data.size());
  return 3 * int64_t(std::count_if(mask.begin(), mask.end(), [](uint8_t m) { return m != 0; }));
}

/// Mean square over images and channels of an image's gain less the mean of its camera's. A
/// camera's own gain is no change: what is compared over time are the same cameras.
double gain_variance(const FrameSample& sample) {
  struct Sum {
    Vec3<double> gain{}, square{};
    int64_t images = 0;
  };
  std::map<std::string_view, Sum> cameras;
  for (size_t i = 0; i < sample.maps.size(); ++i) {
    const Vec3<double> gain = channel_response(sample.maps[i]);
    Sum& sum = cameras[sample.frame(int64_t(i)).camera_name];
    sum.gain += gain;
    sum.square += gain * gain;
    ++sum.images;
  }
  double variance = 0;
  for (const auto& [name, sum] : cameras)
    variance +=
        (dot(sum.square, Vec3<double>(1)) - dot(sum.gain, sum.gain) / double(sum.images)) / 3;
  return sample.maps.empty() ? 0 : std::max(0.0, variance / double(sample.maps.size()));
}

/// The sums of a set, [N] from `first` on, scaled to all frames.
void read_sums(const Buffer<ElementSums<float>>& sums, int64_t first, double share,
               bool motion_known, SetContributions& set) {
  const auto scale = float(1 / share);
  for (size_t n = 0; n < set.weight.size(); ++n) {
    const ElementSums<float>& sum = sums[first + int64_t(n)];
    const float light = std::max(sum.weight, 1e-12f);
    set.weight[n] = scale * sum.weight;
    set.moving[n] = motion_known ? scale * sum.moving : 0;
    set.removal1[n] = scale * sum.removal1;
    set.removal2[n] = scale * sum.removal2;
    set.mean_time[n] = sum.time / light;
    set.opacity[n] = sum.opacity / light;
    for (int d = 0; d < kMaxShDegree; ++d)
      set.truncation_error[n][size_t(d)] = scale * sum.truncation[d];
  }
}

SetContributions::Change change_of(TimeVariation v) {
  close_series(v);
  SetContributions::Change change;
  change.gain = float(v.varying_gain);
  change.timesteps = v.timesteps;
  change.freedom = v.freedom;
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
  for (std::vector<float>* values : {&weight, &moving, &removal1, &removal2, &mean_time, &opacity})
    values->assign(size_t(count), 0.0f);
  truncation_error.assign(size_t(count), {});
  change.assign(size_t(count), {});
}

double Contributions::psnr_after(double added) const {
  return 10 * std::log10(std::max(1.0, samples) / std::max(1e-12, squared_error + added));
}

Contributions measure_contributions(Backend& backend, const GaussianModel& model,
                                    const FrameSample& sample, int64_t frames) {
  Contributions contributions;
  contributions.motion_known = !sample.moving.empty();
  contributions.gain_variance = gain_variance(sample);
  ElementBuffers elements(backend, model, true);
  ScoringPass pass(backend, model, true);
  double squared_error = 0;  // of what was drawn
  int64_t samples = 0;
  const auto draw = [&](int64_t begin, int64_t end) {
    pass.draw(sample, begin, end);
    squared_error += pass.squared_error();
    for (int64_t i = begin; i < end; ++i) samples += counted_samples(sample.frame(i));
    pass.add_to(elements);
  };
  const double share = draw_sample(sample, frames, draw);
  contributions.share = share;
  contributions.squared_error = squared_error / share;
  contributions.samples = double(samples) / share;
  Buffer<ElementSums<float>> sums;
  sums.copy_from(elements.sums);
  int64_t first = 0;
  for (int k = 0; k < 2; ++k) {
    const int64_t count = (k == 0 ? model.static_set : model.dynamic_set).count();
    contributions.sets[k].resize(count);
    read_sums(sums, first, share, contributions.motion_known, contributions.sets[k]);
    first += count;
  }
  Buffer<TimeVariation> variation;
  variation.copy_from(elements.variation);
  for (int64_t n = 0; n < variation.size(); ++n)
    contributions.sets[0].change[size_t(n)] = change_of(variation[n]);
  return contributions;
}

double draw_sample(const FrameSample& sample, int64_t frames,
                   const std::function<void(int64_t begin, int64_t end)>& draw) {
  const int64_t batch = sample.at_once();
  int64_t drawn = 0;
  for (const FrameRange& sweep : sample.sweeps) {
    for (int64_t begin = sweep.begin; begin < sweep.end; begin += batch)
      draw(begin, std::min(begin + batch, sweep.end));
    drawn += sweep.end - sweep.begin;
    if (drawn >= frames) break;
  }
  return sample.count() == 0 ? 1 : double(drawn) / double(sample.count());
}

}  // namespace tessera
