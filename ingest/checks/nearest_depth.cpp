// Depths of a point cloud in the cameras of a scene.
#include "ingest/checks/nearest_depth.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "kernels/base/camera_rig.h"

namespace tessera {

std::optional<double> nearest_depth(const Scene& scene) {
  constexpr size_t kLeastPoints = 500, kPointsPerOutlier = 500;
  std::optional<double> nearest;
  std::set<std::string> known;
  std::vector<double> depths;
  for (const int f : scene.split_indices(Split::kTrain)) {
    const Frame& frame = scene.frames[size_t(f)];
    if (!known.insert(frame.camera_name).second) continue;
    depths.clear();
    for (const glm::vec3& point : scene.points.position) {
      const glm::dvec3 p(point);
      if (sees(frame.camera, p, 0))
        depths.push_back((frame.camera.cam_from_world * p + frame.camera.translation).z);
    }
    if (depths.size() < kLeastPoints) continue;
    const auto first = depths.begin() + std::ptrdiff_t(depths.size() / kPointsPerOutlier);
    std::nth_element(depths.begin(), first, depths.end());
    if (!nearest || *first < *nearest) nearest = *first;
  }
  return nearest;
}

}  // namespace tessera
