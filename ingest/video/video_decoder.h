// Decodes a video file to upright RGB images in the order of their presentation times. Sound and
// frame-rate conversion are not supported.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "ingest/video/frame_colour.h"
#include "ingest/video/frame_timing.h"

namespace tessera {

/// What a file that ends early is: an error, or as many frames as are there and a warning.
enum class Truncation { kRefuse, kKeepWhatIsThere };

struct DecodeOptions {
  Truncation truncation = Truncation::kRefuse;
  int width = 0, height = 0;  // of the images handed out, area averages; 0: the video's own size
};

struct VideoStream {
  int width = 0, height = 0;  // pixels of the upright image
  Rational time_base;         // seconds a tick
  int64_t frames = 0;         // handed out by decode_video; stated by the container in probe_video
  std::vector<std::string> warnings;  // kKeepWhatIsThere: "… truncated after N frames at S s …"
};

struct VideoFrame {
  int64_t ticks = 0;     // presentation time in the stream's time base
  Image8 image;          // RGB, full range, sRGB
  FrameColour colour{};  // of the frame before its conversion to sRGB
};

/// Size, clock and the container's own count of frames (0 where it has none), without decoding.
VideoStream probe_video(const std::filesystem::path& path);

/// Calls `on_frame` in order of presentation until it returns false or the video ends; frames that
/// repeat a presentation time are left out. Decoding and conversion use thread_count() = T threads.
/// Memory: at most T decoded images, 2 T in RGB, and the codec's own min(T + 1, 16) + 16.
/// Errors: InputError naming file, camera, time and the frames read so far: no video in it,
/// truncated (unless kKeepWhatIsThere), damaged, without times, times that go back, an
/// image size that changes, a flag of mirroring or of an angle that is no quarter turn.
VideoStream decode_video(const std::filesystem::path& path,
                         const std::function<bool(VideoFrame)>& on_frame,
                         const DecodeOptions& options = {});

/// Hands over the frames shown at `wanted` (ticks, increasing; as read_timeline states them), in
/// that order, until `on_frame` returns false. Frames before the last keyframe at or before a
/// wanted one are not decoded, frames that are not wanted not converted. Where the container has an
/// index (MP4, Matroska), packets in between are not read; of others the file up to the last wanted
/// frame is read twice (times first). Memory: as decode_video. Errors: as decode_video, and a
/// time at which no frame is shown; a file's truncation only shows as that.
void decode_frames(const std::filesystem::path& path, const std::vector<int64_t>& wanted,
                   const std::function<bool(VideoFrame)>& on_frame,
                   const DecodeOptions& options = {});

}  // namespace tessera
