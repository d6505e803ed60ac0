// The clip of one camera of a rig: a video or numbered images, with their times, their pixels and
// the pose of the camera.
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ingest/images/image_paths.h"
#include "ingest/poses/lens.h"
#include "ingest/video/video_decoder.h"
#include "ingest/video/video_timeline.h"

namespace tessera {

/// A camera's video or numbered images, with its pose where that is known.
struct RigClip {
  std::string name;             // "cam02"
  std::filesystem::path video;  // of images: their folder, or that and what their names begin with
  VideoTimeline timeline;
  std::optional<RigCamera> camera;
  std::vector<NumberedImage> images{};  // numbers are ticks; empty for a video
};

/// Of images: number n is shown at n / image_rate; gaps are warned of. Errors: InputError naming
/// the file: as read_timeline; an image that cannot be read.
VideoTimeline read_clip_timeline(const RigClip& clip, double image_rate);

/// As decode_frames. Images are handed over as stored, RGB or RGBA (grey is repeated), and as many
/// are in memory as there are threads. Errors: as decode_frames; an image that cannot be read or is
/// of another size than the clip.
void decode_clip(const RigClip& clip, const std::vector<int64_t>& wanted,
                 const std::function<bool(VideoFrame)>& on_frame,
                 const DecodeOptions& options = {});

/// source_hash of the video, or one of all images. Errors: InputError: a file cannot be read.
std::string clip_hash(const RigClip& clip);

}  // namespace tessera
