// Reads the timelines of the videos and the poses beside them, which are matched by row or by name.
#include "ingest/layouts/rig_clips.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "ingest/layouts/capture_layout.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/poses/rig_poses_file.h"
#include "ingest/test_views.h"
#include "ingest/video/clip_frames.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLlffFile = "poses_bounds.npy";

std::vector<RigClip> clips_by_name(const fs::path& capture) {
  std::map<std::string, fs::path> videos;
  for (const fs::path& video : videos_in(capture)) {
    const auto [first, is_new] = videos.emplace(video.stem().string(), video);
    if (!is_new)
      throw InputError(
          fmt::format("{}: has the camera '{}' twice, as {} and {}; rename or remove one of them",
                      capture.string(), first->first, first->second.filename().string(),
                      video.filename().string()));
  }
  if (videos.empty())
    throw InputError(
        fmt::format("{}: has no videos; put one file per camera there", capture.string()));
  std::vector<RigClip> clips;
  for (const auto& [name, video] : videos) clips.push_back({name, video, {}, {}});
  return clips;
}

/// Numbered images of several cameras, or of one that moves.
std::vector<RigClip> clips_of_images(const fs::path& capture,
                                     std::optional<ImageLayout> image_layout) {
  std::vector<RigClip> clips;
  for (ImageSequence& sequence : sequences_of(capture, image_layout))
    clips.push_back({sequence.camera, sequence.path, {}, {}, std::move(sequence.images)});
  return clips;
}

std::vector<std::string> names_of(const std::vector<RigClip>& clips) {
  std::vector<std::string> names;
  for (const RigClip& clip : clips) names.push_back(clip.name);
  return names;
}

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

/// Removes clips; `seen` describes why. Errors: InputError `refusal`: `strict`, or fewer than two
/// are left.
void leave_out(const std::string& seen, const std::string& refusal, const std::vector<char>& keep,
               bool strict, RigClips& rig, std::vector<std::string>& warnings) {
  if (std::count(keep.begin(), keep.end(), 1) < 2) throw InputError(refusal);
  if (strict) throw InputError(refusal + ", or leave --strict out to go on without");
  rig.keep_only(keep);
  warnings.push_back(
      fmt::format("{}; the scene is made of the other {} cameras", seen, rig.clips.size()));
}

void pose_by_name(const fs::path& file, bool strict, RigClips& rig,
                  std::vector<std::string>& warnings) {
  std::string missing;
  auto cameras = find_rig_cameras(file, names_of(rig.clips), missing);
  std::vector<char> posed;
  for (size_t i = 0; i < cameras.size(); ++i) {
    posed.push_back(cameras[i].has_value());
    rig.clips[i].camera = std::move(cameras[i]);
  }
  if (!missing.empty())
    leave_out(missing, missing + ": " + kUnposedRemedy, posed, strict, rig, warnings);
}

/// The file that states the poses; empty where none does.
fs::path pose_file(const fs::path& capture, const std::string& source) {
  const fs::path llff = capture / kLlffFile;
  if (source == "colmap" || (source.empty() && !fs::exists(llff))) return {};
  return source.empty() || source == "n3dv" || source == "llff" ? llff : fs::path(source);
}

/// Only the named cameras, in order of their names.
void choose(const std::vector<std::string>& wanted, RigClips& rig) {
  if (wanted.empty()) return;
  const std::vector<std::string> names = names_of(rig.clips);
  std::vector<char> keep(names.size(), 0);
  for (const std::string& name : wanted) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      throw InputError(fmt::format("--cameras: there is no camera '{}'; there are {}", name,
                                   listed_names(names)));
    keep[size_t(found - names.begin())] = 1;
  }
  rig.keep_only(keep);
}

/// Of a single camera frames can be held out (--test-every), not the camera.
void hold_out(const std::vector<std::string>& named, RigClips& rig) {
  rig.held_out.assign(rig.clips.size(), 0);
  if (!named.empty()) {
    const auto splits = held_out_splits_of(names_of(rig.clips), named, "videos");
    for (size_t i = 0; i < splits.size(); ++i) rig.held_out[i] = splits[i] == Split::kTest;
  } else if (rig.clips.size() > 1) {
    rig.held_out.front() = 1;  // as N3DV's protocol has it
  }
}

/// Clips that end early are taken only where the part that is wanted is stated (`bounded`).
void read_timelines(RigClips& rig, double image_rate, bool bounded,
                    std::vector<std::string>& warnings) {
  std::vector<std::string> errors(rig.clips.size());
  parallel_for(int64_t(rig.clips.size()), 1, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i) try {
        rig.clips[i].timeline = read_clip_timeline(rig.clips[i], image_rate);
      } catch (const InputError& error) {
        errors[i] = error.what();
      }
  });
  for (const std::string& error : errors)
    if (!error.empty()) throw InputError(error);
  for (const RigClip& clip : rig.clips) {
    if (clip.timeline.truncated && !bounded)
      throw InputError(fmt::format(
          "{}; copy or encode it again, pass --duration or --frames to use what is there, or leave "
          "the camera out with --cameras",
          clip.timeline.warnings.front()));
    warnings.insert(warnings.end(), clip.timeline.warnings.begin(), clip.timeline.warnings.end());
  }
}

/// Stated cameras take the size of their video.
void fit_sizes(std::vector<RigClip>& clips) {
  for (RigClip& clip : clips)
    clip.camera->camera = camera_of_image(clip.camera->camera, clip.timeline.width,
                                          clip.timeline.height, clip.video.string());
}

}  // namespace

std::vector<std::string> RigClips::names() const {
  return names_of(clips);
}

void RigClips::keep_only(const std::vector<char>& keep) {
  check(keep.size() == clips.size(), "keep_only: one entry a clip");
  RigClips kept;
  for (size_t i = 0; i < clips.size(); ++i) {
    if (!keep[i]) continue;
    kept.clips.push_back(std::move(clips[i]));
    if (!held_out.empty()) kept.held_out.push_back(held_out[i]);
  }
  clips = std::move(kept.clips);
  held_out = std::move(kept.held_out);
}

void leave_out_bad_lenses(bool strict, RigClips& rig, std::vector<std::string>& warnings) {
  std::string first;
  std::vector<std::string> bad;
  std::vector<char> good;
  for (const RigClip& clip : rig.clips) try {
      undistorted_camera(clip.camera->camera, clip.camera->lens,
                         fmt::format("{} ({})", clip.video.string(), clip.camera->lens_model));
      good.push_back(1);
    } catch (const InputError& error) {
      if (bad.empty()) first = error.what();
      bad.push_back(clip.name);
      good.push_back(0);
    }
  if (bad.empty()) return;
  const std::string seen =
      bad.size() == 1 ? first : fmt::format("{} (likewise: {})", first, listed_names(bad));
  leave_out(seen, seen + ", or leave it out with --cameras", good, strict, rig, warnings);
}

RigClips open_rig_clips(const fs::path& capture, const IngestOptions& options,
                        std::vector<std::string>& warnings) {
  RigClips rig;
  const bool of_images = options.layout == CaptureLayout::kSequences;
  rig.clips = of_images ? clips_of_images(capture, options.image_layout) : clips_by_name(capture);
  const fs::path poses = pose_file(capture, options.poses.source);
  const bool by_row = poses.filename() == kLlffFile;
  if (by_row) pose_by_row(poses, rig.clips);  // rows count the videos that are left out, too
  choose(options.cameras, rig);
  if (!poses.empty() && !by_row) pose_by_name(poses, options.strict, rig, warnings);
  rig.posed = !poses.empty();
  if (rig.posed) rig.pose_files.push_back(poses);
  read_timelines(rig, options.image_rate.value_or(kImageRate), options.duration || options.frames,
                 warnings);
  if (rig.posed) {
    fit_sizes(rig.clips);
    leave_out_bad_lenses(options.strict, rig, warnings);
  }
  hold_out(options.held_out, rig);
  return rig;
}

}  // namespace tessera
