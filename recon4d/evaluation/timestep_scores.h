// PSNR of each timestep over all scored cameras, which shows where in time motion fails.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "recon4d/evaluation/pixel_sums.h"

namespace tessera {

struct TimestepScore {
  double time = 0;           // normalised
  int64_t frame_number = 0;  // of the first view of the timestep
  int64_t views = 0;
  /// dB, of the mean squared error over the pixels of all views, 8-bit images.
  double psnr = 0;
  std::optional<double> psnr_dynamic;  // of the moving pixels; nothing where there is none
};

/// Takes the scored views in any order.
class TimestepMeter {
 public:
  void add(const Frame& frame, const ViewPixelSums& sums);
  std::vector<TimestepScore> scores() const;  // timesteps ascend

 private:
  struct Timestep {
    double time;
    int64_t frame_number, views;
    PixelSums moving, all;
  };
  std::vector<Timestep> timesteps_;  // ascending
};

/// The timestep of lowest PSNR, the first one of several; nothing where there is none.
std::optional<TimestepScore> worst_timestep(const std::vector<TimestepScore>& timesteps);

}  // namespace tessera
