// Trainings for tests of exposure: the Gaussians are at their true places and their colours are
// brighter than those of the images.
#pragma once
#include "tests/support/tiny_capture.h"

namespace tessera::testing {

/// Five cameras with three timesteps each.
inline TinyCapture exposed_ring() {
  TinyCapture capture;
  capture.cameras = 5;
  capture.timesteps = 3;
  capture.size = 24;
  return capture;
}

/// The Gaussians that the images show, in brighter colours; no density control moves their rows.
inline TrainOptions still_options(int64_t iterations) {
  TrainOptions options = tiny_options();
  options.iterations = options.schedule_iterations = iterations;
  options.densify_until = 0;
  options.reorder_interval = 0;
  options.sh_degree = 0;
  options.lr_opacity = options.lr_scale = options.lr_rotation = 1e-4;
  return options;
}

/// The truth with its colours times `dim`; images of these tests show it with 0.7.
inline TrainState dimmed_truth(const TinyCapture& capture, double dim) {
  TrainState state;
  state.model = tiny_truth(capture);
  for (int k = 0; k < 2; ++k) {
    for (float& sh : state.set(k).group(kSh).value)
      sh = float((dim * (0.5 + kSh0 * double(sh)) - 0.5) / kSh0);
    state.statistics[k].reset(state.set(k).count());
  }
  return state;
}

/// Colours of all Gaussians, RGB by RGB.
inline std::vector<double> colours_of(const GaussianModel& model) {
  std::vector<double> colours;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set})
    for (const float sh : set->group(kSh).value) colours.push_back(0.5 + kSh0 * double(sh));
  return colours;
}

}  // namespace tessera::testing
