// A model of a clip in the time of one of its windows.
#pragma once
#include <cmath>

#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/windows.h"

namespace tessera::testing {

/// The same motion in the window's time.
inline GaussianModel in_time_of(const FileWindow& window, const GaussianModel& model) {
  GaussianModel moved = model.clone_values();
  const double length = window.time.high - window.time.low;
  const GaussianSpans<float> set = moved.dynamic_set.values();
  for (int64_t n = 0; n < set.count; ++n) {
    *set.at(kMeanTime, n) = float(window_time(window, double(*set.at(kMeanTime, n))));
    *set.at(kLogScaleTime, n) -= float(std::log(length));
    for (int k = 0; k < 3; ++k) set.at(kVelocity, n)[k] *= float(length);
  }
  return moved;
}

}  // namespace tessera::testing
