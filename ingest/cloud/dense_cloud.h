// An initial cloud by plane sweep (plane_sweep.h) from pixels of all training cameras at all
// timesteps of a scene: static points once, moving points with their timesteps.
#pragma once
#include <functional>
#include <vector>

#include "ingest/cloud/plane_sweep.h"
#include "ingest/ingest.h"

namespace tessera {

enum class CloudPart { kAll, kStill, kMoving };

struct CloudOptions {
  int64_t points = kCloudPoints;  // at most
  uint64_t seed = 1;
  std::function<void(int64_t points)> progress;  // may throw to stop
  CloudPart part = CloudPart::kAll;              // of the pixels, that are tried
};

/// Points found in the scene of `sweep`, in random order; the points of the scene are not used.
/// Empty when no three training cameras share a timestep. The same for any number of threads. Tries
/// at most kTriesAPoint · options.points pixels; those of the other part do not count, up to 31 in
/// a row.
inline constexpr int64_t kTriesAPoint = 6;
std::vector<SweptPoint> dense_points(const PlaneSweep& sweep, const CloudOptions& options);

/// With the columns time, still and velocity.
PointCloud cloud_of(const std::vector<SweptPoint>& points);

}  // namespace tessera
