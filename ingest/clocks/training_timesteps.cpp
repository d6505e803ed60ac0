// What: frames of the training split with their cameras and times.
// Not: how frames are grouped (timesteps.h).
#include "ingest/clocks/training_timesteps.h"

namespace tessera {

std::vector<Timestep> training_timesteps(const Scene& scene) {
  std::vector<FrameTime> times;
  for (int i : scene.split_indices(Split::kTrain)) {
    const Frame& frame = scene.frames[size_t(i)];
    times.push_back({frame.camera_name, frame.time, i});
  }
  return group_timesteps(times);
}

}  // namespace tessera
