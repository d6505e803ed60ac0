// What: how well the images of each camera agree with its stated pose, and whether they have the
//       texture to tell.
// Not: a correction of poses.
#pragma once
#include "ingest/checks/feature_matches.h"
#include "ingest/checks/finding.h"

namespace tessera {

struct PoseResidual {
  std::string camera;
  int64_t features = 0, matches = 0;
  int pairs = 0;         // with enough matches to say something
  double residual = -1;  // median over its pairs of their median Sampson distance; −1: unknown
};

struct PoseCheck {
  std::vector<PoseResidual> cameras;  // worst first, unknown ones last
  double median = -1;                 // over the cameras, pixels
  Findings findings;
};
PoseCheck check_poses(const MatchedStations& matched);

}  // namespace tessera
