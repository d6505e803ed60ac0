// Pools the sums of views that show the same timestep.
#include "recon4d/evaluation/timestep_scores.h"

#include <algorithm>

#include "recon4d/evaluation/metrics.h"

namespace tessera {

void TimestepMeter::add(const Frame& frame, const ViewPixelSums& sums) {
  constexpr double kSameTimestep = 1e-9;  // of the normalised range
  auto place =
      std::lower_bound(timesteps_.begin(), timesteps_.end(), frame.time - kSameTimestep,
                       [](const Timestep& timestep, double time) { return timestep.time < time; });
  if (place == timesteps_.end() || place->time > frame.time + kSameTimestep)
    place = timesteps_.insert(place, {frame.time, frame.frame_number, 0, {}, {}});
  ++place->views;
  place->moving += sums.moving;
  place->all += sums.all();
}

std::vector<TimestepScore> TimestepMeter::scores() const {
  std::vector<TimestepScore> scores;
  for (const Timestep& timestep : timesteps_) {
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

}  // namespace tessera
