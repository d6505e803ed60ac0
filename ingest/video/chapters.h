// A recording that its camera has cut into files, chapters, as one clip. Each chapter begins where
// the one before it ends: one median distance of frames after its last frame.
#pragma once
#include <functional>
#include <vector>

#include "ingest/video/clip.h"
#include "ingest/video/video_decoder.h"

namespace tessera {

/// The timeline of the clip's video with those of its chapters behind it; the clock is that of the
/// first. Timecodes that state another time for a chapter are warned of. Errors: InputError: as
/// read_timeline; naming the file: a chapter of another size, clock, rate or colour, a chapter
/// before the last that ends early.
VideoTimeline joined_timeline(const RigClip& clip);

/// As decode_frames, of the clip's video and its chapters; clip.timeline is joined_timeline.
void decode_chapters(const RigClip& clip, const std::vector<int64_t>& wanted,
                     const std::function<bool(VideoFrame)>& on_frame, const DecodeOptions& options);

}  // namespace tessera
