// Matches stated poses to clips by row or by name, and reads the timelines of those that are taken.
#include <fmt/format.h>

#include <algorithm>

#include "ingest/layouts/image_sequences.h"
#include "ingest/poses/llff_poses.h"
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

constexpr const char* kLlffFile = "poses_bounds.npy";

/// Row i of the file is video i by name, of all videos that are there.
void pose_by_row(const fs::path& file, std::vector<RigClip>& clips) {
  const std::vector<LlffPose> poses = read_llff_poses(file);
  if (poses.size() != clips.size())
    throw InputError(fmt::format(
        "{}: has {} rows, the folder has {} videos; remove the videos without a pose or add the "
        "missing ones",
        file.string(), poses.size(), clips.size()));
  for (size_t i = 0; i < clips.size(); ++i)
    clips[i].camera = RigCamera{clips[i].name, poses[i].camera, {}, "PINHOLE"};
}

void pose_by_name(const fs::path& file, bool strict, Capture& capture) {
  std::string missing;
  auto cameras = find_rig_cameras(file, clip_names(capture), missing);
  std::vector<char> posed;
  for (size_t i = 0; i < cameras.size(); ++i) {
    posed.push_back(cameras[i].has_value());
    capture.clips[i].camera = std::move(cameras[i]);
  }
  if (!missing.empty())
    leave_out_clips(missing, missing + ": " + kUnposedRemedy, posed, strict, capture);
}

/// The file that states the poses; empty where none does.
fs::path pose_file(const fs::path& folder, const std::string& source) {
  const fs::path llff = folder / kLlffFile;
  if (source == "colmap" || (source.empty() && !fs::exists(llff))) return {};
  return source.empty() || source == "n3dv" || source == "llff" ? llff : fs::path(source);
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

/// Of a single camera frames can be held out (--test-every), not the camera.
void hold_out(const IngestOptions& options, Capture& capture) {
  const size_t count = capture.clips.size();
  if (options.test_every && count > 1)
    throw InputError(
        "--test-every is given, but of several cameras whole ones are held out; pass --held-out "
        "with their names");
  capture.held_out.assign(count, 0);
  if (!options.held_out.empty()) {
    const auto splits = held_out_splits_of(clip_names(capture), options.held_out, "videos");
    for (size_t i = 0; i < count; ++i) capture.held_out[i] = splits[i] == Split::kTest;
  } else if (count > 1) {
    capture.held_out.front() = 1;  // as N3DV's protocol has it
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

/// Stated cameras take the size of their video.
void fit_sizes(std::vector<RigClip>& clips) {
  for (RigClip& clip : clips)
    clip.camera->camera = camera_of_image(clip.camera->camera, clip.timeline.width,
                                          clip.timeline.height, clip.video.string());
}

}  // namespace

Capture open_clips(Capture capture, const StepContext& context) {
  if (capture.clips.empty()) return capture;
  const IngestOptions& options = context.options;
  const fs::path poses = pose_file(capture.folder, options.poses.source);
  const bool by_row = poses.filename() == kLlffFile;
  if (by_row) pose_by_row(poses, capture.clips);  // rows count the videos that are left out, too
  choose_cameras(options.cameras, capture);
  if (!poses.empty() && !by_row) pose_by_name(poses, options.strict, capture);
  read_timelines(options, capture);
  if (!poses.empty()) {
    fit_sizes(capture.clips);
    leave_out_bad_lenses(options.strict, capture);
    take_origin_out(capture);
    capture.posed = true;
    capture.files.emplace_back(poses.filename().string(), poses);
    capture.points_file = "";
    if (capture.layout == "videos") capture.layout = "n3dv";
  }
  if (options.layout == CaptureLayout::kSequences)
    capture.notes.push_back(fmt::format("{}: {}", capture.folder.string(),
                                        reading_text(capture.clips.size(), *options.image_rate)));
  hold_out(options, capture);
  check_clips(capture, options);
  return capture;
}

}  // namespace tessera
