// Checks of the timesteps of a scene: their number, gaps of a camera, cameras with another time
// range, the uncertainty of the clock offsets, and the share of the image that moves.
#pragma once
#include <string>
#include <vector>

#include "ingest/checks/finding.h"
#include "ingest/scene.h"

namespace tessera {

struct CameraTimes {
  std::string camera;
  int64_t frames = 0;
  double first = 0, last = 0;  // normalised
  int64_t missing = 0;         // timesteps within its range where its frames are too far apart
};

struct SceneTimes {
  int64_t timesteps = 0;   // of the clip, whatever the clocks
  double duration = 0;     // in the capture's own unit
  bool is_static = false;  // one timestep
  std::vector<CameraTimes> cameras;
  Findings findings;
};
/// Needs no pixels; of all frames. Cameras with several poses count as one.
/// `in_seconds`: the capture's own unit is known to be that.
SceneTimes check_times(const Scene& scene, bool in_seconds = false);

/// Share of the pixels that change by more than 10 % of white over the loaded timesteps, mean over
/// the static training cameras; −1 where none has two timesteps. Needs pixels.
double dynamic_share(const Scene& scene);

/// What a preparation recorded of a camera's clock; seconds.
struct RecordedClock {
  std::string camera, source;  // source: "motion", "audio", "container", "stated", "none" or empty
  double offset = 0;           // added to its times
  double uncertainty = 0;      // standard error; 0: stated or not measured
};

/// Names clocks that could not be measured, and those whose uncertainty exceeds a quarter of a
/// frame of `scene`: warnings where there are offsets, else nothing speaks against them. Needs no
/// pixels.
Findings check_clocks(const Scene& scene, const std::vector<RecordedClock>& clocks);

}  // namespace tessera
