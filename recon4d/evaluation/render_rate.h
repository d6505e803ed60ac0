// What: how many images a second a model gives on a backend: one view at a time, warm.
// Not: training, and no reading, scoring or copying of images.
// Source: failure mode D8.
#pragma once
#include <vector>

#include "recon4d/evaluation/render.h"

namespace tessera {

struct RenderRateOptions {
  int64_t frames = 300;  // to be timed
  double seconds = 20;   // fewer where they do not fit in this time; at least one
  int64_t warm_up = 10;  // rendered before
};

struct RenderRate {
  int64_t frames = 0;         // that were timed
  double seconds = 0;         // they took: the device's events, or the host's clock
  double wall_seconds = 0;    // the same with launches and waits between them
  int width = 0, height = 0;  // of the first view
  int64_t num_gaussians = 0;

  double fps() const { return seconds > 0 ? double(frames) / seconds : 0; }
};

/// Views in turn, at least one.
RenderRate measure_render_rate(Backend& backend, const GaussianModel& model,
                               const std::vector<View>& views,
                               const RenderRateOptions& options = {});

}  // namespace tessera
