// What: SIFT features of each station's median image, matched to the stations whose view overlaps
//       most, and how far each match lies from its epipolar line under the stated poses.
// Not: estimation; poses select pairs of stations but, but for a loose gate, no matches.
#pragma once
#include <vector>

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

/// First-order distance of a match to the epipolar geometry of two cameras, pixels  [Sampson].
double sampson_distance(const Camera& a, const Camera& b, const FeatureMatch& match);

}  // namespace tessera
