// Gives clips the cameras that a calibration states, and reads the timelines of those that are
// taken.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "ingest/calibration/stated_cameras.h"
#include "ingest/colmap/colmap_records.h"
#include "ingest/poses/rig_poses_file.h"
#include "ingest/steps/kept_frames.h"
#include "ingest/steps/left_out_clips.h"
#include "ingest/steps/steps.h"
#include "ingest/test_views.h"
#include "ingest/video/clip_frames.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Cameras of all clips, those that are left out later, too: rows count all. Returns why what lies
/// there is not used, in one line, where no camera is stated.
std::optional<StatedCameras> take_stated_cameras(const IngestOptions& options, Capture& capture) {
  std::vector<std::string> unused;
  std::optional<StatedCameras> stated = stated_cameras(
      capture.folder, options.poses.source, clip_names(capture), options.cameras, unused);
  capture.warnings.insert(capture.warnings.end(), unused.begin(), unused.end());
  if (stated)
    for (size_t i = 0; i < capture.clips.size(); ++i)
      capture.clips[i].camera = std::move(stated->cameras[i]);
  else
    capture.unused_poses = fmt::format("{}", fmt::join(unused, "; "));
  return stated;
}

/// Leaves out the clips for which `stated` has no camera.
void leave_out_unposed(const StatedCameras& stated, bool strict, Capture& capture) {
  std::vector<char> posed;
  std::vector<std::string> missing;
  for (const RigClip& clip : capture.clips) {
    posed.push_back(clip.camera.has_value());
    if (!clip.camera) missing.push_back(clip.name);
  }
  if (missing.empty()) return;
  const std::string seen = fmt::format("{}: has no camera for {}; it has {}", stated.path.string(),
                                       listed_names(missing), listed_names(stated.stated_names));
  leave_out_clips(seen,
                  seen + ": rename them alike, or leave those without a pose out of the capture",
                  posed, strict, capture);
}

/// Only the named cameras, in order of their names.
void choose_cameras(const std::vector<std::string>& wanted, Capture& capture) {
  if (wanted.empty()) return;
  const std::vector<std::string> names = clip_names(capture);
  std::vector<char> keep(names.size(), 0);
  for (const std::string& name : wanted) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      throw InputError(fmt::format("--cameras: there is no camera '{}'; there are {}", name,
                                   listed_names(names)));
    keep[size_t(found - names.begin())] = 1;
  }
  keep_clips(capture, keep);
}

/// Of a single camera frames can be held out (--test-every), not the camera. Of several cameras
/// those that are named, else the innermost, as soon as it is known; of N3DV its protocol's.
void hold_out(const IngestOptions& options, bool by_row, Capture& capture) {
  const size_t count = capture.clips.size();
  if (options.test_every && count > 1)
    throw InputError(
        "--test-every is given, but of several cameras whole ones are held out; pass --held-out "
        "with their names, or none");
  if (options.held_out.empty() && count > 1 && !capture.posed) return;  // by COLMAP's poses
  capture.held_out.assign(count, 0);
  if (!options.held_out.empty()) {
    const auto splits = held_out_splits_of(clip_names(capture), options.held_out, "videos");
    for (size_t i = 0; i < count; ++i) capture.held_out[i] = splits[i] == Split::kTest;
  } else if (count > 1) {
    std::vector<glm::dvec3> centres;
    for (const RigClip& clip : capture.clips) centres.push_back(clip.camera->camera.position());
    capture.held_out[by_row ? 0 : innermost(centres)] = 1;
  }
}

/// Clips that end early are taken only where the part that is wanted is stated.
void read_timelines(const IngestOptions& options, Capture& capture) {
  std::vector<RigClip>& clips = capture.clips;
  std::vector<std::string> errors(clips.size());
  parallel_for(int64_t(clips.size()), 1, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i) try {
        clips[i].timeline = read_clip_timeline(clips[i], options.image_rate.value_or(kImageRate));
      } catch (const InputError& error) {
        errors[i] = error.what();
      }
  });
  for (const std::string& error : errors)
    if (!error.empty()) throw InputError(error);
  for (const RigClip& clip : clips) {
    const std::vector<std::string>& warnings = clip.timeline.warnings;
    if (clip.timeline.truncated && !options.duration && !options.frames)
      throw InputError(fmt::format(
          "{}; copy or encode it again, pass --duration or --frames to use what is there, or leave "
          "the camera out with --cameras",
          warnings.front()));
    capture.warnings.insert(capture.warnings.end(), warnings.begin(), warnings.end());
  }
}

/// Anamorphic clips, and a lens model that does not fit them.
void note_pixel_aspect(const std::string& lens_model, Capture& capture) {
  std::vector<std::string> names;
  const VideoTimeline* first = nullptr;
  for (const RigClip& clip : capture.clips) {
    if (clip.timeline.has_square_pixels()) continue;
    names.push_back(clip.name);
    if (first == nullptr) first = &clip.timeline;
  }
  if (first == nullptr) return;
  capture.notes.push_back(
      fmt::format("{}: {}x{} pixels that are {:.3f} times as wide as high, shown as {}x{}; images "
                  "keep them, and cameras have two focal lengths",
                  listed_names(names), first->width, first->height, first->pixel_aspect,
                  first->shown_width(), first->height));
  if (lens_model.empty() || has_two_focal_lengths(lens_model)) return;
  capture.warnings.push_back(fmt::format(
      "--camera-model {} has one focal length, which pixels that are not square do not ({}); leave "
      "it out, or pass OPENCV",
      lens_model, listed_names(names)));
}

/// Stated cameras take the size of their video.
void fit_sizes(std::vector<RigClip>& clips) {
  for (RigClip& clip : clips)
    clip.camera->camera =
        camera_of_image(clip.camera->camera, clip.timeline.width, clip.timeline.height,
                        clip.timeline.shown_width(), clip.video.string());
}

/// The world is that of the calibration, and so are its points; without any, those of the folder.
void take_poses(StatedCameras stated, const IngestOptions& options, Capture& capture) {
  fit_sizes(capture.clips);
  leave_out_bad_lenses(options, capture);
  capture.origin = stated.origin;
  take_origin_out(capture);
  capture.posed = true;
  for (const fs::path& file : stated.files)
    capture.files.emplace_back(file.filename().string(), file);
  for (std::string& note : stated.notes) capture.notes.push_back(std::move(note));
  if (stated.points.position.empty())
    capture.points_file = "";
  else
    capture.points = std::move(stated.points);
  if (capture.layout == "videos") capture.layout = "n3dv";
}

}  // namespace

Capture open_clips(Capture capture, const StepContext& context) {
  if (capture.clips.empty()) return capture;
  IngestOptions options = context.options;
  options.cameras = whole_names(options.cameras, clip_names(capture));
  std::optional<StatedCameras> stated = take_stated_cameras(options, capture);
  choose_cameras(options.cameras, capture);
  if (stated) leave_out_unposed(*stated, options.strict, capture);
  read_timelines(options, capture);
  note_pixel_aspect(options.poses.lens_model, capture);
  const bool by_row = stated && stated->by_row;
  if (stated) take_poses(std::move(*stated), options, capture);
  hold_out(options, by_row, capture);
  check_clips(capture, options);
  return capture;
}

}  // namespace tessera
