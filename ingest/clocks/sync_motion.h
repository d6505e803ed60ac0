// What: clock offsets from what the images show moving.
// Not: the choice between methods (clock_sync.h).
#pragma once
#include <vector>

#include "ingest/clocks/clock_sync.h"

namespace tessera {

/// One clock a clip, their median 0. A clip whose offset cannot be told keeps 0, the source "none"
/// and a warning, as does one without a pose; an offset within offset_limits() is left at 0, its
/// measured value beside it. Errors: InputError: a clock that drifts against the others'. Memory:
/// 512 MB of images at most, and for each clip 17 MB and 90 kB a frame of three seconds.
ClipClocks synchronise_by_motion(const std::vector<RigClip>& clips, const IngestProgress& progress);

}  // namespace tessera
