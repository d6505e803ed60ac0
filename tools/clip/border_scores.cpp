// Sums over pairs of images that follow each other.
#include "tools/clip/border_scores.h"

#include <algorithm>
#include <cmath>

#include "recon4d/evaluation/dynamic_regions.h"

namespace tessera {
namespace {

float steps_of(float value) {
  return value > 0.0F ? 255.0F * std::min(value, 1.0F) : 0.0F;  // NaN counts as 0
}

std::optional<double> mean(double sum, int64_t count) {
  return count > 0 ? std::optional(sum / double(count)) : std::nullopt;
}

}  // namespace

void BorderMeter::add(const Frame& frame, const RenderedImage& image) {
  std::vector<float> drawn(image.rgb.size());
  std::transform(image.rgb.begin(), image.rgb.end(), drawn.begin(), steps_of);
  const auto before = last_.find(frame.camera_name);
  if (before != last_.end() && before->second.frame.camera == frame.camera) {
    const Shown& last = before->second;
    Sums& sums = last.window == window_ ? inside_ : border_;
    const size_t pixels = frame.image.data.size() / 3;
    for (size_t p = 0; p < pixels; ++p) {
      const auto ignores = [&](const FrameMask& mask) {
        return !mask.data().empty() && mask.data()[p] == 0;
      };
      if (ignores(frame.mask) || ignores(last.frame.mask)) continue;
      double error = 0;
      int largest = 0;
      for (size_t c = 0; c < 3; ++c) {
        const int change = int(frame.image.data[3 * p + c]) - int(last.frame.image.data[3 * p + c]);
        const size_t i = c * pixels + p;
        error += std::abs(double(drawn[i]) - double(last.drawn[i]) - change);
        largest = std::max(largest, std::abs(change));
      }
      sums.all += error;
      sums.all_count += 3;
      if (largest <= DynamicRegions::kThreshold) continue;
      sums.moving += error;
      sums.moving_count += 3;
    }
  }
  last_[frame.camera_name] = {frame, std::move(drawn), window_};
}

BorderScore BorderMeter::score() const {
  const auto errors = [](const Sums& sums) {
    return ChangeErrors{mean(sums.all, sums.all_count), mean(sums.moving, sums.moving_count)};
  };
  return {errors(inside_), errors(border_)};
}

}  // namespace tessera
