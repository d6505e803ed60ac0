// What: clips for tests of the clocks.
// Not: assertions.
#include "tests/ingest/sync_fixture.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "ingest/llff_poses.h"
#include "ingest/media/video_decoder.h"
#include "ingest/offset_solver.h"

namespace tessera::testing {

namespace fs = std::filesystem;

std::vector<RigClip> clips_of(const fs::path& folder) {
  std::vector<RigClip> clips;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".mp4") continue;
    RigClip& clip = clips.emplace_back();
    clip.name = entry.path().stem().string(), clip.video = entry.path();
    VideoTimeline& timeline = clip.timeline;
    const VideoStream stream = decode_video(entry.path(), [&](const VideoFrame& frame) {
      timeline.ticks.push_back(frame.ticks);
      return true;
    });
    timeline.width = stream.width, timeline.height = stream.height;
    timeline.time_base = stream.time_base;
    std::vector<double> steps;
    for (size_t i = 1; i < timeline.ticks.size(); ++i)
      steps.push_back(timeline.seconds(i) - timeline.seconds(i - 1));
    timeline.frame_seconds = median_offset(steps);
  }
  std::sort(clips.begin(), clips.end(),
            [](const RigClip& a, const RigClip& b) { return a.name < b.name; });
  if (fs::exists(folder / "poses_bounds.npy")) {
    const std::vector<LlffPose> poses = read_llff_poses(folder / "poses_bounds.npy");
    for (size_t i = 0; i < clips.size(); ++i)
      clips[i].camera = RigCamera{clips[i].name, poses[i].camera, {}, "PINHOLE"};
  }
  return clips;
}

void pose_by_opencv_json(const fs::path& file, std::vector<RigClip>& clips) {
  std::ifstream stream(file);
  const auto json = nlohmann::json::parse(stream);
  for (size_t i = 0; i < clips.size(); ++i) {
    const auto& row = json.at("cameras").at(i);
    RigCamera rig;
    rig.name = clips[i].name, rig.lens_model = "OPENCV";
    rig.camera.width = row.at("w"), rig.camera.height = row.at("h");
    rig.camera.fl_x = row.at("fx"), rig.camera.fl_y = row.at("fy");
    rig.camera.cx = row.at("cx"), rig.camera.cy = row.at("cy");
    rig.lens.k1 = row.at("k1"), rig.lens.k2 = row.at("k2");
    rig.lens.p1 = row.at("p1"), rig.lens.p2 = row.at("p2");
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        rig.camera.cam_from_world[c][r] = row.at("R_w2c").at(size_t(r)).at(size_t(c));
      rig.camera.translation[r] = row.at("t_w2c").at(size_t(r));
    }
    clips[i].camera = rig;
  }
}

void make_rig(const fs::path& folder, const std::vector<double>& shifts) {
  SynthOptions options;
  options.cameras = 5, options.frames = 36, options.fps = {30, 1}, options.points = 10;
  options.supersampling = 2, options.shifts = shifts;
  make_capture(options, folder, {});
}

std::vector<double> frames_of(const ClipClocks& clocks, const std::vector<RigClip>& clips) {
  std::vector<double> frames;
  for (size_t i = 0; i < clips.size(); ++i)
    frames.push_back(clocks.clocks[i].offset / clips[i].timeline.frame_seconds);
  return frames;
}

std::string text_of(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += fmt::format("{:+.3f} ", value);
  return text;
}

}  // namespace tessera::testing
