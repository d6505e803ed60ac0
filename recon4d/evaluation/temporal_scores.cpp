// Running sums over time for the planes of a camera.
#include "recon4d/evaluation/temporal_scores.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr int64_t kPixelsOfTask = 1 << 14;  // pixels of a task

float steps_of(float value) {
  return value > 0.0f ? 255.0f * std::min(value, 1.0f) : 0.0f;  // NaN counts as 0
}

}  // namespace

void FlickerMeter::start(Sums& sums, const Frame& frame) {
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

void FlickerMeter::take(const Frame& frame, const RenderedImage& image, Sums& sums) {
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
  const auto pixels = int64_t(sums.used.size());
  struct Change {
    double sum = 0;
    int64_t count = 0;
  };
  std::vector<Change> changes(size_t((pixels + kPixelsOfTask - 1) / kPixelsOfTask));
  parallel_for(pixels, kPixelsOfTask, [&](int64_t begin, int64_t end) {
    Change change;
    for (auto p = size_t(begin); p < size_t(end); ++p) {
      const bool was_used = sums.used[p] != 0;
      if (!frame.mask.data().empty() && frame.mask.data()[p] == 0) sums.used[p] = 0;
      if (!was_used) continue;
      for (size_t c = 0; c < 3; ++c) {
        const size_t i = c * size_t(pixels) + p;
        const float drawn = steps_of(image.rgb[i]), truth = frame.image.data[3 * p + c];
        if (last != nullptr && sums.used[p] != 0) {
          const float truth_change = truth - float(last->image.data[3 * p + c]);
          change.sum += std::abs((drawn - sums.previous[i]) - truth_change);
          ++change.count;
        }
        sums.previous[i] = drawn;
        for (int k = 0; k < 2; ++k) {
          const float value = k == 0 ? drawn : truth, before = value - sums.mean[k][i];
          sums.mean[k][i] += before / timesteps;
          sums.square[k][i] += before * (value - sums.mean[k][i]);
        }
      }
    }
    changes[size_t(begin / kPixelsOfTask)] = change;
  });
  for (const Change& change : changes) {  // in order, so that threads change no digit
    sums.change_sum += change.sum;
    sums.change_count += change.count;
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

}  // namespace tessera
