// Which frames of the clips of a rig are kept: those of the window that was asked for, within the
// time that they share. Cameras that film a part of it, of another rate and of other colours are
// named.
#pragma once
#include <vector>

#include "ingest/capture/capture.h"
#include "ingest/clocks/frame_window.h"
#include "ingest/ingest.h"

namespace tessera {

/// What the lengths, rates and colours of the clips tell before COLMAP has worked for minutes.
/// Errors: InputError: --start is after the end of all clips.
void check_clips(Capture& capture, const IngestOptions& options);

/// Indices of the kept frames of each clip, increasing. `timesteps`: the times of each clip's
/// frames on the rig's clock, seconds. What is lost as cameras begin or end apart is warned of, and
/// so are those in Capture::partial. Errors: InputError: nothing in common, the window begins after
/// the end, a camera without a frame in the window.
std::vector<std::vector<size_t>> kept_frames(Capture& capture, const FrameWindow& window,
                                             const std::vector<std::vector<double>>& timesteps);

}  // namespace tessera
