// Clips for the tests of clock synchronisation.
#include "tests/ingest/clocks/sync_fixture.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/calibration/stated_cameras.h"
#include "ingest/poses/rig_poses_file.h"

namespace tessera::testing {

namespace fs = std::filesystem;

namespace {

void pose_by_file(const fs::path& file, std::vector<RigClip>& clips) {
  std::vector<std::string> names;
  for (const RigClip& clip : clips) names.push_back(clip.name);
  std::vector<std::string> warnings;
  const auto stated =
      stated_cameras(file.parent_path(), {PoseSource::kCameras, file}, names, {}, warnings);
  for (size_t i = 0; i < clips.size(); ++i) {
    RigCamera& camera = clips[i].camera.emplace(stated->cameras[i].value());
    const VideoTimeline& timeline = clips[i].timeline;
    camera.camera = camera_of_image(camera.camera, timeline.width, timeline.height,
                                    timeline.shown_width(), clips[i].name);
  }
}

}  // namespace

std::vector<RigClip> clips_of(const fs::path& folder) {
  std::vector<RigClip> clips;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".mp4") continue;
    RigClip& clip = clips.emplace_back();
    clip.name = entry.path().stem().string();
    clip.video = entry.path();
    clip.timeline = read_timeline(clip.video);
  }
  std::sort(clips.begin(), clips.end(),
            [](const RigClip& a, const RigClip& b) { return a.name < b.name; });
  for (const char* poses : {"poses_bounds.npy", "cameras_opencv.json"})
    if (fs::exists(folder / poses)) pose_by_file(folder / poses, clips);
  return clips;
}

void make_rig(const fs::path& folder, SynthOptions options) {
  options.cameras = 4;
  options.points = 10;
  options.supersampling = 2;
  make_capture(options, folder, {});
}

std::vector<double> frames_of(const ClipClocks& clocks, const std::vector<RigClip>& clips,
                              double ClipClock::*value) {
  std::vector<double> frames;
  for (size_t i = 0; i < clips.size(); ++i)
    frames.push_back(clocks.clocks[i].*value / clips[i].timeline.frame_seconds);
  return frames;
}

std::string text_of(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += fmt::format("{:+.3f} ", value);
  return text;
}

}  // namespace tessera::testing
