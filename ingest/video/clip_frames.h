// Reads the times and the pixels of the clip of one camera.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "ingest/video/clip.h"
#include "ingest/video/video_decoder.h"
#include "ingest/video/video_timeline.h"

namespace tessera {

/// Of images: number n is shown at n / image_rate; gaps are warned of. Chapters of a video follow
/// each other without a gap, as chapters.h has it. Errors: InputError naming the file: as
/// read_timeline and joined_timeline; an image that cannot be read.
VideoTimeline read_clip_timeline(const RigClip& clip, double image_rate);

/// As decode_frames. Images are handed over as stored, RGB or RGBA (grey is repeated), and as many
/// are in memory as there are threads. Errors: as decode_frames; an image that cannot be read or is
/// of another size than the clip.
void decode_clip(const RigClip& clip, const std::vector<int64_t>& wanted,
                 const std::function<bool(VideoFrame)>& on_frame,
                 const DecodeOptions& options = {});

/// source_hash of the video, or one of all chapters or images. Errors: InputError: a file cannot be
/// read.
std::string clip_hash(const RigClip& clip);

}  // namespace tessera
