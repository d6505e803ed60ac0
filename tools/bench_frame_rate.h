// What: frames per second of drawing a model, one view after the other, pictures left where they
//       are drawn.
// Not: writing, copying or scoring pictures.
#pragma once
#include <vector>

#include "kernels/backend.h"
#include "recon4d/gaussian_set.h"

namespace tessera {

struct FrameRate {
  double frames_per_second = 0;
  int64_t frames = 0;  // measured
};

/// Views in turn, one at a time. A tenth of `frames` goes first, unmeasured; where they take longer
/// than `seconds`, fewer are measured, at least one.
FrameRate measure_frame_rate(Backend& backend, const GaussianModel& model,
                             const std::vector<View>& views, int64_t frames = 300,
                             double seconds = 3);

}  // namespace tessera
