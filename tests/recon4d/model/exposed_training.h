// Trainings for tests of exposure and of clocks: the Gaussians are at their true places, their
// colours brighter than those of the images, or the images filmed later.
#pragma once
#include "tests/support/tiny_capture.h"

namespace tessera::testing {

/// Five cameras with three timesteps each.
inline TinyCapture exposed_ring() {
  TinyCapture capture{.cameras = 5, .timesteps = 3, .size = 24};
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

/// Camera c films `late[c]` frames later than its times say.
inline Scene late_capture(const TinyCapture& capture, const std::vector<double>& late) {
  Scene scene = tiny_capture(capture);
  const double frame = 1 / double(capture.timesteps - 1);
  for (size_t c = 0; c < late.size(); ++c) {
    GaussianModel earlier = tiny_truth(capture);
    for (float& time : earlier.dynamic_set.group(kMeanTime).value) time -= float(late[c] * frame);
    const Scene filmed = tiny_capture(capture, earlier);
    for (size_t f = c * size_t(capture.timesteps); f < (c + 1) * size_t(capture.timesteps); ++f)
      scene.frames[f].image = filmed.frames[f].image;
  }
  return scene;
}

}  // namespace tessera::testing
