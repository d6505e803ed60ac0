// What: how well the clocks of a prepared scene's cameras are known.
// Not: their measurement (ingest/clocks/clock_sync.h).
#pragma once
#include <string>
#include <vector>

#include "ingest/checks/finding.h"
#include "ingest/scene.h"

namespace tessera {

/// What a preparation recorded of a camera's clock; seconds.
struct RecordedClock {
  std::string camera, source;  // source: "motion", "audio", "container", "stated", "none" or empty
  double offset = 0;           // added to its times
  double uncertainty = 0;      // standard error; 0: stated or not looked at
};

/// Warns of clocks that could not be measured, and of those that are only known to more than a
/// quarter of a frame of `scene`, and says what was done with them. Needs no pixels.
Findings check_clocks(const Scene& scene, const std::vector<RecordedClock>& clocks);

}  // namespace tessera
