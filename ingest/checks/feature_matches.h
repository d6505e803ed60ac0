// SIFT features of the median image of each station, matched between stations whose views overlap,
// and the distance of each match to its epipolar line under the stated poses. Poses only choose the
// pairs of stations and reject gross mismatches.
#pragma once
#include <vector>

#include "ingest/checks/finding.h"
#include "ingest/checks/stations.h"

namespace tessera {

struct FeatureMatch {
  double ax = 0, ay = 0, bx = 0, by = 0;  // pixels in the two images
  double residual = 0;                    // Sampson distance, pixels
};

struct StationPair {
  int a = 0, b = 0;                   // stations
  std::vector<FeatureMatch> matches;  // within the gate, in both directions each other's best
};

struct MatchedStations {
  std::vector<Station> stations;
  std::vector<Image8> images;     // [stations] medians over time
  std::vector<int64_t> features;  // [stations] found, at most kMostFeatures
  std::vector<StationPair> pairs;
  bool moving_camera = false;  // of a scene that moves: stations have different timesteps
};

inline constexpr int kMostFeatures = 1500;

/// Of the stations of all splits. Needs pixels.
MatchedStations match_stations(const Scene& scene);

struct PoseResidual {
  std::string camera;
  int64_t features = 0, matches = 0;
  int pairs = 0;         // with enough matches
  double residual = -1;  // median over its pairs of their median Sampson distance; −1: unknown
};

struct PoseCheck {
  std::vector<PoseResidual> cameras;  // worst first, unknown ones last
  double median = -1;                 // over the cameras, pixels
  Findings findings;
};
PoseCheck check_poses(const MatchedStations& matched);

}  // namespace tessera
