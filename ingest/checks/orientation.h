// Finds cameras of a rig that are turned about their viewing direction relative to the others: on
// their side, or upside down. Only poses are used; moving cameras are skipped.
#pragma once
#include <string>
#include <vector>

#include "ingest/checks/finding.h"
#include "ingest/scene.h"

namespace tessera {

struct CameraRoll {
  std::string camera;
  double degrees = 0;  // clockwise turn of its image against upright, (−180, 180]
  bool known = false;  // false where the camera looks along the rig's up direction
};

struct OrientationCheck {
  std::vector<CameraRoll> cameras;  // in the order of the files; empty for cameras that move
  Findings findings;
};
/// Up is the direction that most cameras agree on. Needs no pixels; of cameras of all splits that
/// have several timesteps and one pose.
OrientationCheck check_orientation(const Scene& scene);

/// "cam02, cam04 are higher than wide (360x640), the 2 others wider than high"; empty where all are
/// alike. `sizes`: width and height by camera.
std::string mixed_orientation(const std::vector<std::string>& cameras,
                              const std::vector<std::pair<int, int>>& sizes);

}  // namespace tessera
