// What: a video file → RGB pictures with their presentation times, one at a time.
// Not: a player: no seeking, no audio, no frame-rate conversion; a frame's index is never its time.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>

#include "ingest/rational.h"
#include "ingest/scene.h"

namespace tessera {

struct VideoStream {
  int width = 0, height = 0;  // pixels
  Rational time_base;         // seconds a tick
  int64_t frames = 0;         // decoded by decode_video; stated by the container in probe_video
};

struct VideoFrame {
  int64_t ticks = 0;  // presentation time in the stream's time base
  Image8 image;       // RGB, full range
};

/// Size, clock and the container's own count of frames (0 where it has none), without decoding.
VideoStream probe_video(const std::filesystem::path& path);

/// Calls `on_frame` in order of presentation until it returns false or the video ends. Errors:
/// InputError naming the file and the frames read so far: no video in it, truncated, corrupt,
/// without timestamps, timestamps that go back, a picture size that changes, a rotation flag.
VideoStream decode_video(const std::filesystem::path& path,
                         const std::function<bool(VideoFrame)>& on_frame);

}  // namespace tessera
