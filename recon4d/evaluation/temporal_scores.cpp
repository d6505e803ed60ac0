// Running sums over time for the planes of a camera, and medians over time.
#include "recon4d/evaluation/temporal_scores.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/median.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr int64_t kPixelsOfTask = 1 << 14;  // pixels of a task

float steps_of(float value) {
  return value > 0.0f ? 255.0f * std::min(value, 1.0f) : 0.0f;  // NaN counts as 0
}

}  // namespace

void FlickerMeter::start(Sums& sums, const Frame& frame) const {
  const size_t pixels = size_t(frame.image.width) * size_t(frame.image.height);
  sums.previous.assign(3 * pixels, 0.0f);
  for (int k = 0; k < 2; ++k) {
    sums.mean[k].assign(3 * pixels, 0.0f);
    sums.square[k].assign(3 * pixels, 0.0f);
  }
  sums.used.assign(pixels, 255);
}

void FlickerMeter::add(const Frame& frame, const RenderedImage& image) {
  const std::string& camera = frame.camera_name;
  Sums& sums = cameras_[camera];
  take(frame, image, sums);
  if (--left_[camera] > 0) return;
  if (!sums.broken && sums.timesteps > 1) scores_[camera] = score(camera, sums);
  cameras_.erase(camera);
}

void FlickerMeter::take(const Frame& frame, const RenderedImage& image, Sums& sums) const {
  if (sums.broken) return;
  const Frame* const last = sums.last;
  sums.broken = last != nullptr && !(frame.camera == last->camera && frame.time > last->time);
  if (sums.broken) {
    sums = Sums();
    sums.broken = true;
    return;
  }
  if (last == nullptr) start(sums, frame);
  sums.last = &frame;
  const auto timesteps = float(++sums.timesteps);
  const size_t pixels = sums.used.size();
  for (size_t p = 0; p < pixels; ++p) {
    const bool was_used = sums.used[p] != 0;
    if (!frame.mask.data().empty() && frame.mask.data()[p] == 0) sums.used[p] = 0;
    if (!was_used) continue;
    for (size_t c = 0; c < 3; ++c) {
      const size_t i = c * pixels + p;
      const float drawn = steps_of(image.rgb[i]), truth = frame.image.data[3 * p + c];
      if (last != nullptr && sums.used[p] != 0) {
        const float truth_change = truth - float(last->image.data[3 * p + c]);
        sums.change_sum += std::abs((drawn - sums.previous[i]) - truth_change);
        ++sums.change_count;
      }
      sums.previous[i] = drawn;
      for (int k = 0; k < 2; ++k) {
        const float value = k == 0 ? drawn : truth, before = value - sums.mean[k][i];
        sums.mean[k][i] += before / timesteps;
        sums.square[k][i] += before * (value - sums.mean[k][i]);
      }
    }
  }
}

FlickerScore FlickerMeter::score(const std::string& camera, const Sums& sums) {
  FlickerScore score;
  score.camera = camera;
  score.timesteps = sums.timesteps;
  score.change_error = sums.change_sum / double(std::max<int64_t>(1, sums.change_count));
  const size_t pixels = sums.used.size();
  double deviation[2] = {};
  int64_t still = 0, all = 0;
  for (size_t i = 0; i < 3 * pixels; ++i) {
    if (sums.used[i % pixels] == 0) continue;
    ++all;
    const auto error = [&](int k) { return std::sqrt(sums.square[k][i] / double(sums.timesteps)); };
    if (error(1) >= FlickerScore::kStillDeviation) continue;
    deviation[0] += error(0);
    deviation[1] += error(1);
    ++still;
  }
  score.still_share = all > 0 ? double(still) / double(all) : 0;
  if (still == 0) return score;
  score.still_deviation = deviation[0] / double(still);
  score.still_deviation_truth = deviation[1] / double(still);
  return score;
}

std::vector<FlickerScore> FlickerMeter::scores() const {
  std::vector<FlickerScore> scores;
  for (const auto& [camera, score] : scores_) scores.push_back(score);
  return scores;
}

const std::vector<uint8_t>& DynamicRegions::median_of(const Frame& frame) {
  const auto found = medians_.find(frame.camera_name);
  if (found != medians_.end()) return found->second;
  std::vector<uint8_t>& median = medians_[frame.camera_name];
  std::vector<const Frame*> frames;
  for (const Frame& other : scene_.frames) {
    if (other.camera_name != frame.camera_name) continue;
    if (of_ == Of::kTrainingFrames && other.split != Split::kTrain) continue;
    if (!(other.camera == frame.camera)) return median;
    frames.push_back(&other);
  }
  std::stable_sort(frames.begin(), frames.end(),
                   [](const Frame* a, const Frame* b) { return a->time < b->time; });
  std::vector<const Frame*> chosen;
  const size_t count = std::min(frames.size(), kMoments);
  if (count < kLeastMoments) return median;
  for (size_t i = 0; i < count; ++i)
    chosen.push_back(
        frames[size_t(even_spread(int64_t(i), int64_t(count), int64_t(frames.size())))]);
  median.resize(frame.image.data.size());
  parallel_for(int64_t(median.size()), kPixelsOfTask, [&](int64_t begin, int64_t end) {
    std::vector<uint8_t> values(count);
    for (int64_t i = begin; i < end; ++i) {
      for (size_t k = 0; k < count; ++k) values[k] = chosen[k]->image.data[size_t(i)];
      const auto middle = values.begin() + std::ptrdiff_t((count - 1) / 2);
      std::nth_element(values.begin(), middle, values.end());
      median[size_t(i)] = *middle;
    }
  });
  return median;
}

std::vector<uint8_t> DynamicRegions::mask_of(const Frame& frame) {
  const std::vector<uint8_t>& median = median_of(frame);
  if (median.empty()) return {};
  std::vector<uint8_t> moves(median.size() / 3, 0);
  for (size_t i = 0; i < median.size(); ++i)
    if (std::abs(int(frame.image.data[i]) - int(median[i])) > kThreshold) moves[i / 3] = 255;
  return moves;
}

}  // namespace tessera
