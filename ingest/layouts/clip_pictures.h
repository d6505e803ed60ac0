// Writes the chosen frames of one clip as prepared images: undistorted, scaled, as PNG.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>
#include "ingest/ingest.h"

#include "ingest/video/clip_frames.h"

namespace tessera {

struct ClipFrames {
  std::vector<int64_t> ticks;      // increasing, in the clip's time base
  std::vector<std::string> files;  // below the scene's folder; one a frame
};

/// What the images of a clip share.
struct PreparedClip {
  Camera camera;
  std::string mask_path;  // below the scene's folder; empty without a mask
  bool has_alpha = false;
};

/// Decodes the frames of `clip`, whose camera is known, in order of presentation and writes them
/// below `folder`, and the camera's mask where there is one. In memory: two images a thread
/// beside the decoder's (video_decoder.h). Errors: InputError naming the video.
PreparedClip write_clip_images(const RigClip& clip, const ClipFrames& frames,
                               const std::filesystem::path& folder, const IngestOptions& options,
                               const std::function<void()>& on_image);

}  // namespace tessera
