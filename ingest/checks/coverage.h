// Which parts of a scene several training cameras see, and which cameras share their view.
// Occlusion is not considered: a point inside the image of a camera counts as seen.
#pragma once
#include <vector>

#include "ingest/checks/finding.h"
#include "ingest/checks/stations.h"

namespace tessera {

/// Sample points: at most `most` of the cloud; without a cloud a grid in each station's view
/// at half, once and twice the distance of the point nearest to all viewing axes.
std::vector<glm::dvec3> view_samples(const Scene& scene, const std::vector<Station>& stations,
                                     size_t most);

/// For each station up to `most` others that see most of its samples, best first.
std::vector<std::vector<int>> overlapping_stations(const std::vector<Station>& stations,
                                                   const std::vector<glm::dvec3>& samples,
                                                   size_t most);

struct CoverageCheck {
  bool by_cloud = false;          // by points of the cloud, else by a grid
  double seen_by_none = 0;        // share of the samples
  double seen_by_one = 0;         // share of the samples
  std::vector<std::string> name;  // [stations] of training
  std::vector<double> alone;      // [stations] share of its samples that no other station sees
  Findings findings;
};
CoverageCheck check_coverage(const Scene& scene);

}  // namespace tessera
