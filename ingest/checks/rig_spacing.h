// What new views to expect of a rig, from the number of its training cameras, and where a further
// camera would help most. The figures are measured ones (research/few_cameras.md).
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ingest/checks/finding.h"
#include "ingest/checks/stations.h"

namespace tessera {

struct RigSpacing {
  int64_t cameras = 0;
  double angle = 0;                  // neighbour_angle, degrees
  std::array<std::string, 2> gap{};  // neighbours that are farthest apart; empty of one camera
  double gap_angle = 0;              // seen from what the cameras look at, degrees
};

/// `stations`: of training, one or more. Two cameras are neighbours where none is nearer to the
/// direction between them than they are.
RigSpacing rig_spacing(const std::vector<Station>& stations);

/// A warning of fewer than six training cameras, information of fewer than eight, else none.
/// `held_out`: whether filmed cameras are kept for the score.
std::optional<Finding> expected_views(const std::vector<Station>& stations, bool held_out);

}  // namespace tessera
