// Opens the videos or image sequences of a capture as the clips of a rig, with names, timelines,
// stated poses and held-out cameras, and writes their chosen frames as prepared images.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "ingest/ingest.h"
#include "ingest/video/clip_frames.h"

namespace tessera {

struct RigClips {
  std::vector<RigClip> clips;                     // by name; `camera` is set where poses are stated
  std::vector<char> held_out;                     // one a clip
  bool posed = false;                             // all clips have their camera
  std::vector<std::filesystem::path> pose_files;  // that were read

  std::vector<std::string> names() const;
  /// Leaves clips out, all entries alike; `keep` has one entry a clip.
  void keep_only(const std::vector<char>& keep);
};

/// The videos directly in `capture`, those of options.cameras where some are named. Poses are those
/// of options.poses.source: "n3dv", a file, "colmap" (none stated), or empty: poses_bounds.npy
/// where it is there. Errors: InputError: no video, two of one name, an unknown camera, rows
/// that do not fit, another shape than the poses'. Videos without a camera in a file of cameras,
/// and those whose lens cannot be removed, are left out and named in `warnings`; they are errors
/// under options.strict and where fewer than two are left.
RigClips open_rig_clips(const std::filesystem::path& capture, const IngestOptions& options,
                        std::vector<std::string>& warnings);

/// Leaves out the clips, all posed, whose lens has no undistorted image (lens.h), as above.
void leave_out_bad_lenses(bool strict, RigClips& rig, std::vector<std::string>& warnings);

struct ClipFrames {
  std::vector<int64_t> ticks;      // increasing, in the clip's time base
  std::vector<std::string> files;  // below the scene's folder; one a frame
};

/// What the images of a clip share.
struct PreparedClip {
  Camera camera;
  std::string mask_path;  // below the scene's folder; empty without a mask
  bool has_alpha = false;
  std::string tone_map = "none";  // what made sRGB of its frames (tone_map_of)
};

/// Decodes the frames of `clip`, whose camera is known, in order of presentation and writes them
/// below `folder`, and the camera's mask where there is one. In memory: two images a thread
/// beside the decoder's (video_decoder.h). Errors: InputError naming the video.
PreparedClip write_clip_images(const RigClip& clip, const ClipFrames& frames,
                               const std::filesystem::path& folder, const IngestOptions& options,
                               const std::function<void()>& on_image);

}  // namespace tessera
