// Pools the pixel sums of views by timestep, and those within boxes by object and timestep.
#include "recon4d/evaluation/timestep_scores.h"

#include <algorithm>

#include "recon4d/evaluation/metrics.h"

namespace tessera {
namespace {

ViewPixelSums box_sums(const Frame& frame, const Image8& drawn, const ObjectBox& box) {
  ViewPixelSums sums;
  const Span<const uint8_t> mask = used_mask(frame);
  const int right = std::min(box.x1, drawn.width), bottom = std::min(box.y1, drawn.height);
  for (int y = std::max(box.y0, 0); y < bottom; ++y)
    for (int x = std::max(box.x0, 0); x < right; ++x) {
      const size_t p = size_t(y) * size_t(drawn.width) + size_t(x);
      if (!is_used(mask, p)) continue;
      sums.still.add(&drawn.data[3 * p], &frame.image.data[3 * p]);
    }
  return sums;
}

}  // namespace

void TimestepMeter::add(const Frame& frame, const ViewPixelSums& sums) {
  Timestep& timestep = timesteps_[frame.timestep];
  if (timestep.views++ == 0) {
    timestep.time = frame.time;
    timestep.frame_number = frame.frame_number;
  }
  timestep.moving += sums.moving;
  timestep.all += sums.all();
}

std::vector<TimestepScore> TimestepMeter::scores() const {
  std::vector<TimestepScore> scores;
  for (const auto& [number, timestep] : timesteps_) {
    TimestepScore score{timestep.time,
                        timestep.frame_number,
                        timestep.views,
                        psnr_of_mse(timestep.all.mean_squared_error()),
                        {}};
    if (timestep.moving.pixels > 0)
      score.psnr_dynamic = psnr_of_mse(timestep.moving.mean_squared_error());
    scores.push_back(score);
  }
  return scores;
}

std::optional<TimestepScore> worst_timestep(const std::vector<TimestepScore>& timesteps) {
  if (timesteps.empty()) return std::nullopt;
  return *std::min_element(
      timesteps.begin(), timesteps.end(),
      [](const TimestepScore& a, const TimestepScore& b) { return a.psnr < b.psnr; });
}

void ObjectMeter::add(const Frame& frame, const Image8& drawn, const NamedBoxes& boxes) {
  check_pair(drawn, frame.image);
  for (const auto& [name, box] : boxes) {
    const ViewPixelSums sums = box_sums(frame, drawn, box);
    if (sums.still.pixels == 0) continue;
    objects_[name].all += sums.still;
    objects_[name].timesteps.add(frame, sums);
  }
}

std::vector<ObjectScore> ObjectMeter::scores() const {
  std::vector<ObjectScore> scores;
  for (const auto& [name, object] : objects_)
    scores.push_back(
        {name, psnr_of_mse(object.all.mean_squared_error()), object.timesteps.scores()});
  return scores;
}

}  // namespace tessera
