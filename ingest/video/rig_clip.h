// What: what a camera of a rig has filmed: a video or numbered images, their times, its pose.
// Not: pixels (clip_frames.h).
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/images/image_paths.h"
#include "ingest/poses/rig_camera.h"
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

}  // namespace tessera
