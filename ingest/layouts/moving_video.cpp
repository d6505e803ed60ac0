// Converts one video of a moving camera to a prepared scene: frames are written as photos in the
// order of their times, COLMAP estimates a pose for each, and the photos get their times back.
#include "ingest/layouts/conversion.h"

#include <fmt/format.h>

#include <map>

#include "ingest/clocks/frame_window.h"
#include "ingest/clocks/timesteps.h"
#include "ingest/colmap/pose_estimation.h"
#include "ingest/files/atomic_file.h"
#include "ingest/video/clip_frames.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostFrames = 300;  // by default; matching takes minutes

std::vector<size_t> frames_of(const RigClip& clip, const IngestOptions& options) {
  std::vector<double> seconds;
  for (const int64_t ticks : clip.timeline.ticks)
    seconds.push_back(clip.timeline.time_base.at(ticks));
  const FrameWindow window{options.start, options.duration, options.fps, options.frames};
  const TimeInterval whole = common_interval({seconds});
  check_start(window, whole, clip.video.string());
  std::vector<size_t> chosen = choose_frames(seconds, window, whole);
  if (options.fps || options.duration || options.frames || chosen.size() <= kMostFrames)
    return chosen;
  std::vector<size_t> thinned;
  for (size_t i = 0; i < kMostFrames; ++i)
    thinned.push_back(chosen[i * (chosen.size() - 1) / (kMostFrames - 1)]);
  return thinned;
}

struct WrittenFrames {
  std::map<std::string, int64_t> times;  // presentation times by NAME
  std::string tone_map = "none";         // what made sRGB of them
};

/// Writes the frames as NAME.png.
WrittenFrames write_frames(const RigClip& clip, const fs::path& folder,
                           const IngestOptions& options, const IngestProgress& progress) {
  fs::remove_all(folder);
  make_folder(folder);
  std::vector<int64_t> wanted;
  for (const size_t frame : frames_of(clip, options)) wanted.push_back(clip.timeline.ticks[frame]);
  WrittenFrames written;
  decode_clip(clip, wanted, [&](VideoFrame decoded) {
    const std::string name = fmt::format("{:06}", written.times.size());
    written.times[name] = decoded.ticks;
    written.tone_map = tone_map_of(decoded.colour);
    write_prepared_image(folder / (name + ".png"), std::move(decoded.image), 1);
    progress("decoding " + clip.video.filename().string(), int64_t(written.times.size()),
             int64_t(wanted.size()));
    return true;
  });
  return written;
}

/// Frames of photos become frames of one camera at their times.
void set_times(const RigClip& clip, const std::map<std::string, int64_t>& times, bool one_timestep,
               const std::string& where, PreparedScene& scene) {
  std::vector<double> seconds;
  PreparedCamera camera = scene.cameras.front();
  camera.name = clip.name;
  camera.time_base = clip.timeline.time_base;
  for (PreparedFrame& prepared : scene.frames) {
    const int64_t ticks = times.at(prepared.frame.camera_name);
    prepared.ticks = ticks;
    prepared.frame.frame_number = int64_t(seconds.size());
    prepared.frame.camera_name = clip.name;
    seconds.push_back(camera.time_base.at(ticks));
  }
  scene.cameras = {camera};
  scene.time_base = camera.time_base;
  if (one_timestep) return;
  const NormalisedTimes normalised = normalise_times(seconds, false, where);
  for (size_t i = 0; i < scene.frames.size(); ++i) scene.frames[i].frame.time = normalised.time[i];
  scene.time_axis = normalised.axis;
  scene.is_static = normalised.is_static;
}

}  // namespace

Converted convert_moving_video(const fs::path& capture, const RigClip& clip, const fs::path& folder,
                               const IngestOptions& options, const IngestProgress& progress) {
  const fs::path images = options.work / "frames";
  const WrittenFrames written = write_frames(clip, images, options, progress);
  const MovingCameraModel estimate =
      estimate_moving_camera(images, true, options.work / "colmap", options.poses, progress);
  Converted converted = convert_photos(capture, images, read_colmap_model(estimate.folder), folder,
                                       options, progress);
  std::vector<std::string>& warnings = converted.report.warnings;
  warnings.insert(warnings.begin(), estimate.warnings.begin(), estimate.warnings.end());
  converted.scene.layout = clip.images.empty() ? "videos" : "sequences";
  set_times(clip, written.times, options.allow_static, clip.video.string(), converted.scene);
  if (written.tone_map != "none") converted.scene.tone_map = written.tone_map;
  converted.scene.sources = {{clip.video.filename().string(), clip_hash(clip)}};
  converted.report.cameras = 1;
  fs::remove_all(images);
  return converted;
}

}  // namespace tessera
