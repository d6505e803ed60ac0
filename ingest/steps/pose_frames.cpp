// The frames of a moving camera are written as photos in the order of their times, COLMAP estimates
// a pose for each, and the photos get their times back.
#include <fmt/format.h>

#include "ingest/clocks/frame_window.h"
#include "ingest/colmap/pose_estimation.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
#include "ingest/layouts/layout_readers.h"
#include "ingest/steps/pose_hints.h"
#include "ingest/steps/prepared_image.h"
#include "ingest/steps/sample.h"
#include "ingest/steps/steps.h"
#include "ingest/video/clip_frames.h"
#include "ingest/video/frame_colour.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostFrames = 300;  // by default; matching takes minutes

/// Presentation times of the frames that are taken.
std::vector<int64_t> taken_ticks(const RigClip& clip, const FrameWindow& window) {
  std::vector<double> seconds;
  for (size_t i = 0; i < clip.timeline.ticks.size(); ++i)
    seconds.push_back(clip.timeline.seconds(i));
  const TimeInterval whole{seconds.front(), seconds.back()};
  check_start(window, whole, clip.video.string());
  const std::vector<size_t> chosen = choose_frames(seconds, window, whole);
  const bool is_stated = window.fps || window.duration || window.frames;
  const size_t count = is_stated ? chosen.size() : std::min(chosen.size(), kMostFrames);
  std::vector<int64_t> ticks;
  for (size_t i = 0; i < count; ++i) {
    const int64_t place = even_spread(int64_t(i), int64_t(count), int64_t(chosen.size()));
    ticks.push_back(clip.timeline.ticks[chosen[size_t(place)]]);
  }
  return ticks;
}

/// Writes the frames as NUMBER.png in their order. Returns what made sRGB of them.
std::string write_frames(const RigClip& clip, const std::vector<int64_t>& ticks,
                         const fs::path& folder, const IngestProgress& progress) {
  fs::remove_all(folder);
  make_folder(folder);
  std::string tone_map = "none";
  int64_t count = 0;
  decode_clip(clip, ticks, [&](VideoFrame decoded) {
    tone_map = tone_map_of(decoded.colour);
    write_png(folder / fmt::format("{:06}.png", count++), decoded.image);
    progress("decoding " + clip.video.filename().string(), count, int64_t(ticks.size()));
    return true;
  });
  return tone_map;
}

/// COLMAP's poses of the images in capture.photos become its frames. Returns a line about them.
std::string pose_photos(bool in_order, const StepContext& context, Capture& capture) {
  const IngestOptions& options = context.options;
  PoseOptions poses = options.poses;
  if (in_order && poses.lens_model.empty() && !capture.clips.front().timeline.has_square_pixels())
    poses.lens_model = "OPENCV";  // with two focal lengths
  const MovingCameraModel estimate = estimate_moving_camera(
      capture.photos, in_order, options.work / "colmap", poses, context.progress);
  ColmapModel model = read_colmap_model(estimate.folder);
  const std::string registered = fmt::format(
      "COLMAP registered {} of {} photos, mean reprojection error {:.2f} pixels{}",
      model.photos.size(), estimate.images, model.error, estimate.reused ? kReused : "");
  capture.warnings.insert(capture.warnings.end(), estimate.warnings.begin(),
                          estimate.warnings.end());
  take_photos(std::move(model), options.strict, capture);
  return registered;
}

/// The photos become frames of one camera at their times.
void set_clip_times(const RigClip& clip, const std::vector<int64_t>& ticks, Capture& capture) {
  CaptureCamera camera{.name = clip.name, .time_base = clip.timeline.time_base};
  if (!capture.cameras.empty()) camera.removed_lenses = capture.cameras.front().removed_lenses;
  int64_t number = 0;
  for (CaptureFrame& frame : capture.frames) {
    frame.ticks = ticks.at(std::stoul(frame.image_name));
    frame.source = {};  // the clip is it
    frame.frame.frame_number = number++;
    frame.frame.camera_name = clip.name;
    frame.frame.time = camera.time_base.at(*frame.ticks);
  }
  capture.time_base = camera.time_base;
  capture.cameras = {std::move(camera)};
}

Capture pose_moving_clip(Capture capture, const StepContext& context) {
  const RigClip& clip = capture.clips.front();
  const std::vector<int64_t> ticks = taken_ticks(clip, window_of(capture, context.options));
  capture.photos = context.options.work / "frames";
  const std::string tone_map = write_frames(clip, ticks, capture.photos, context.progress);
  try {
    pose_photos(true, context, capture);
  } catch (const InputError& error) {
    throw InputError(error.what() + pose_hints(capture));
  }
  capture.tone_map = tone_map;
  set_clip_times(clip, ticks, capture);
  capture.files.clear();
  capture.times_from = clip.video;
  capture.is_timed = !context.options.allow_static;
  return capture;
}

}  // namespace

Capture pose_frames(Capture capture, const StepContext& context) {
  if (capture.posed) return capture;
  if (!capture.clips.empty()) return pose_moving_clip(std::move(capture), context);
  std::string registered = pose_photos(false, context, capture);
  capture.notes.insert(capture.notes.begin(), std::move(registered));
  return capture;
}

}  // namespace tessera
