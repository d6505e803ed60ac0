// Projects the points into all frames of the timestep, each at the frame's own time.
#include "ingest/cloud/expected_motion.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "ingest/cloud/plane_sweep.h"

namespace tessera {

ExpectedMotion::ExpectedMotion(const Scene& scene, const std::vector<int>& frames,
                               const std::vector<SweptPoint>& points) {
  for (const int index : frames) {
    const Frame& frame = scene.frames[size_t(index)];
    Cells& cells = cells_[index];
    for (const SweptPoint& point : points) {
      if (point.velocity == glm::vec3(0)) continue;
      const double apart = frame.time - scene.frames[size_t(point.frame)].time;
      const glm::dvec3 velocity(point.velocity);
      largest_shift_ =
          std::max(largest_shift_, std::abs(apart) * glm::length(velocity) / double(point.pixel));
      const Camera& camera = frame.camera;
      const glm::dvec3 p = camera.cam_from_world * place_at(point, apart) + camera.translation;
      if (p.z <= 0) continue;
      const double x = camera.fl_x * p.x / p.z + camera.cx;
      const double y = camera.fl_y * p.y / p.z + camera.cy;
      if (!(x >= 0 && y >= 0 && x < camera.width && y < camera.height)) continue;
      cells[{int(x) / kReach, int(y) / kReach}].push_back({x, y, velocity});
    }
  }
}

std::optional<glm::dvec3> ExpectedMotion::at(int frame, int x, int y) const {
  const Cells& cells = cells_.at(frame);
  std::optional<glm::dvec3> velocity;
  double nearest = double(kReach) * kReach;
  for (int row = y / kReach - 1; row <= y / kReach + 1; ++row)
    for (int column = x / kReach - 1; column <= x / kReach + 1; ++column) {
      const auto cell = cells.find({column, row});
      if (cell == cells.end()) continue;
      for (const Seen& seen : cell->second) {
        const double dx = seen.x - x - 0.5, dy = seen.y - y - 0.5;
        if (dx * dx + dy * dy >= nearest) continue;
        nearest = dx * dx + dy * dy;
        velocity = seen.velocity;
      }
    }
  return velocity;
}

}  // namespace tessera
