// What: one video of a camera that moves → prepared scene: frames, a pose each by COLMAP.
// Not: a rig (video_capture.cpp): there every camera stands still.
#pragma once
#include "ingest/layouts/conversion.h"
#include "ingest/layouts/rig_clips.h"

namespace tessera {

/// `clip` has no pose. Without --fps, --duration or --frames at most 300 frames are taken, evenly.
/// Times are the frames' own; every 8th frame is for the test (options.test_every). Errors: as
/// ingest_capture.
Converted convert_moving_video(const std::filesystem::path& capture, const RigClip& clip,
                               const std::filesystem::path& folder, const IngestOptions& options,
                               const IngestProgress& progress);

}  // namespace tessera
