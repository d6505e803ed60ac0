// What: how much later or earlier each camera's clock runs than the rig's, from the videos.
// Not: resampling: frames keep their timesteps, the offset is added to their times.
#pragma once
#include <string>
#include <vector>

#include "ingest/ingest.h"
#include "ingest/video/rig_clip.h"

namespace tessera {

struct ClipClock {
  double offset = 0;       // seconds added to the clip's own presentation times
  double measured = 0;     // what was measured or stated, of which `offset` keeps what is certain
  double uncertainty = 0;  // standard error of it, seconds; 0 where it was stated
  std::string source;      // "stated", "container", "audio", "motion", "none"
};

/// One entry a clip. Gauge: the median of measured offsets is 0, so that most clocks stay; stated
/// ones are kept as they are.
struct ClipClocks {
  std::vector<ClipClock> clocks;
  std::vector<std::string> warnings;  // one line each, with the camera's name
};

/// Errors: InputError naming file or camera and the remedy.
ClipClocks synchronise(const std::vector<RigClip>& clips, const SyncOptions& options,
                       const IngestProgress& progress);

}  // namespace tessera
