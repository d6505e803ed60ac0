// What: a folder of videos as the clips of a rig, with the poses that lie beside them.
// Not: the readers of timelines and poses of the product.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/media/clock_sync.h"
#include "tools/synth/synth.h"

namespace tessera::testing {

/// All *.mp4 of the folder by name, posed by poses_bounds.npy where it is there.
std::vector<RigClip> clips_of(const std::filesystem::path& folder);
/// Poses from video_4cam's cameras_opencv.json, for videos of any width.
void pose_by_opencv_json(const std::filesystem::path& file, std::vector<RigClip>& clips);

/// A `synth room` rig as `folder`: 5 cameras, 36 frames, 30 a second.
void make_rig(const std::filesystem::path& folder, const std::vector<double>& shifts);

/// Offset of each clip in its frames.
std::vector<double> frames_of(const ClipClocks& clocks, const std::vector<RigClip>& clips);
/// "0.01 -0.02 …" for a report.
std::string text_of(const std::vector<double>& values);

}  // namespace tessera::testing
