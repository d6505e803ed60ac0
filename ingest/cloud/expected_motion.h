// The velocity that a pixel probably shows: that of a moving point which was found near it. Cameras
// of one timestep whose clocks differ see what moves at different places.
#pragma once
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

struct SweptPoint;

class ExpectedMotion {
 public:
  /// `frames`: of one timestep, indices into the frames of `scene`, which `points` were found in.
  /// Points at rest say nothing.
  ExpectedMotion(const Scene& scene, const std::vector<int>& frames,
                 const std::vector<SweptPoint>& points);

  /// World units per unit of normalised time, of the nearest point within kReach pixels; none where
  /// there is no point.
  std::optional<glm::dvec3> at(int frame, int x, int y) const;

  /// Farthest that a point moves between the times of two cameras, pixels where it was found.
  double largest_shift() const { return largest_shift_; }

  static constexpr int kReach = 16;

 private:
  struct Seen {
    double x, y;  // pixels
    glm::dvec3 velocity;
  };
  using Cells = std::map<std::pair<int, int>, std::vector<Seen>>;  // kReach pixels wide

  std::map<int, Cells> cells_;  // by frame
  double largest_shift_ = 0;
};

}  // namespace tessera
