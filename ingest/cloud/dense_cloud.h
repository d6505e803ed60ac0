// What: an initial cloud by plane sweep: pixels of all training cameras at all timesteps of a
// scene,
//       still points once, moving ones with their timesteps.
// Not: dense stereo, and no points of monocular captures; the search is plane_sweep.h.
#pragma once
#include <functional>

#include "ingest/scene.h"

namespace tessera {

struct CloudOptions {
  int64_t points = 100000;  // at most
  uint64_t seed = 1;
  std::function<void(int64_t points)> progress;  // may throw to stop
};

/// Points found in `scene`, in random order, with times and `still`; its own points are not looked
/// at. Empty when no three training cameras share a timestep. The same for any number of threads.
/// Tries at most kTriesAPoint · options.points pixels.
inline constexpr int64_t kTriesAPoint = 6;
PointCloud dense_cloud(const Scene& scene, const CloudOptions& options);

}  // namespace tessera
