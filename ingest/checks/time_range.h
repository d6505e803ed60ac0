// What: the timesteps of a scene: one or several, gaps in a camera, cameras of another range; and
//       how much of the images moves.
// Not: clocks (ingest/clocks/clock_sync.h); offsets that were found are in the frames' times.
#pragma once
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
  int64_t timesteps = 0;   // distinct times
  double duration = 0;     // in the capture's own unit
  bool is_static = false;  // one timestep
  std::vector<CameraTimes> cameras;
  Findings findings;
};
/// Needs no pixels; of all frames. Cameras with several poses count as one.
SceneTimes check_times(const Scene& scene);

/// Share of the pixels that change by more than 10 % of white over the loaded timesteps, mean over
/// the training cameras that stand still; −1 where none has two timesteps. Needs pixels.
double dynamic_share(const Scene& scene);

}  // namespace tessera
