// Converts videos or image sequences, one a camera, to a prepared scene: poses, clocks, the choice
// of frames by time, images.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/checks/orientation.h"
#include "ingest/clocks/clock_note.h"
#include "ingest/clocks/clock_sync.h"
#include "ingest/clocks/timesteps.h"
#include "ingest/colmap/pose_estimation.h"
#include "ingest/files/fnv1a.h"
#include "ingest/files/point_cloud.h"
#include "ingest/layouts/conversion.h"
#include "ingest/layouts/image_sequences.h"
#include "ingest/layouts/kept_frames.h"
#include "ingest/layouts/rig_clips.h"
#include "ingest/test_views.h"
#include "ingest/video/clip_frames.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct Work {
  const fs::path& capture;
  const fs::path& folder;
  const IngestOptions& options;
  const IngestProgress& progress;
};

/// How numbered images are read, for people.
std::string reading_of(const Work& work, const RigClips& rig) {
  return fmt::format("{}: {}", work.capture.string(),
                     reading_text(rig.clips.size(), *work.options.image_rate));
}

/// What explains why no poses were found: numbered images may be none of a rig's.
std::string reading_hint(const Work& work, const RigClips& rig) {
  return rig.clips.front().images.empty() ? "" : "; " + reading_of(work, rig);
}

/// A hint about differing image shapes where no poses could be found; empty where they are alike.
std::string turned_hint(const RigClips& rig) {
  std::vector<std::pair<int, int>> sizes;
  for (const RigClip& clip : rig.clips)
    sizes.emplace_back(clip.timeline.width, clip.timeline.height);
  const std::string mixed = mixed_orientation(rig.names(), sizes);
  return mixed.empty() ? "" : "; " + mixed + ": check whether their videos lack a rotation flag";
}

/// Poses by COLMAP; cameras that it could not place are left out. Returns its points.
PointCloud place_cameras(const Work& work, RigClips& rig, IngestReport& report) {
  PoseEstimate estimate = [&] {
    try {
      return estimate_rig(rig.clips, rig.held_out, work.options.work / "colmap", work.options.poses,
                          work.progress);
    } catch (const InputError& error) {
      throw InputError(error.what() + turned_hint(rig) + reading_hint(work, rig));
    }
  }();
  std::vector<std::string>& warnings = report.warnings;
  warnings.insert(warnings.end(), estimate.warnings.begin(), estimate.warnings.end());
  std::vector<char> placed;
  for (size_t i = 0; i < rig.clips.size(); ++i) {
    rig.clips[i].camera = std::move(estimate.cameras[i]);
    placed.push_back(rig.clips[i].camera.has_value());
  }
  report.notes.push_back(
      fmt::format("COLMAP registered {} of {} cameras, mean reprojection error {:.2f} pixels{}",
                  std::count(placed.begin(), placed.end(), 1), placed.size(), estimate.error,
                  estimate.reused ? kReused : ""));
  rig.keep_only(placed);
  leave_out_bad_lenses(work.options.strict, rig, warnings);
  if (std::all_of(rig.held_out.begin(), rig.held_out.end(), [](char held) { return held; }))
    throw InputError(fmt::format(
        "{}: only held-out cameras could be placed, none is left to train on; name others with "
        "--held-out",
        work.capture.string()));
  return std::move(estimate.points);
}

/// Images of one number are of one timestep unless a method is stated.
SyncOptions sync_of(bool of_images, SyncOptions sync) {
  if (of_images && sync.method == SyncMethod::kAuto) sync.method = SyncMethod::kNone;
  return sync;
}

/// The timesteps of each clip's frames on the rig's clock, seconds.
std::vector<std::vector<double>> rig_timesteps(const RigClips& rig, const ClipClocks& clocks) {
  std::vector<std::vector<double>> timesteps;
  for (size_t i = 0; i < rig.clips.size(); ++i) {
    std::vector<double>& of_clip = timesteps.emplace_back();
    for (const int64_t ticks : rig.clips[i].timeline.ticks)
      of_clip.push_back(rig.clips[i].timeline.time_base.at(ticks) + clocks.clocks[i].offset);
  }
  return timesteps;
}

/// Adds the frames of clip `i` to the scene and their timesteps to `seconds`.
void describe_frames(const RigClips& rig, size_t i, const std::vector<size_t>& chosen,
                     const std::vector<double>& timesteps, PreparedScene& scene, ClipFrames& frames,
                     std::vector<double>& seconds) {
  const RigClip& clip = rig.clips[i];
  for (size_t k = 0; k < chosen.size(); ++k) {
    PreparedFrame prepared;
    prepared.frame.name = fmt::format("{}/{:05}", clip.name, k);
    prepared.file_path = prepared.frame.name + ".png";
    prepared.frame.camera_name = clip.name;
    prepared.frame.frame_number = int64_t(k);
    prepared.frame.split = rig.held_out[i] ? Split::kTest : Split::kTrain;
    prepared.ticks = clip.timeline.ticks[chosen[k]];
    frames.ticks.push_back(*prepared.ticks);
    frames.files.push_back(prepared.file_path);
    seconds.push_back(timesteps[chosen[k]]);
    scene.frames.push_back(std::move(prepared));
  }
}

/// Every Nth frame of a single static camera, whose pose is stated.
void hold_out_frames(int64_t every, PreparedScene& scene) {
  std::vector<std::string> names;
  for (const PreparedFrame& prepared : scene.frames) names.push_back(prepared.frame.name);
  const std::vector<Split> splits = every_nth_split(names, every);
  for (size_t i = 0; i < names.size(); ++i) scene.frames[i].frame.split = splits[i];
}

void record_camera(const RigClip& clip, const ClipClock& clock, const PreparedClip& prepared,
                   PreparedScene& scene) {
  PreparedCamera camera;
  camera.name = clip.name;
  camera.time_base = clip.timeline.time_base;
  camera.time_offset = clock.offset;
  camera.time_uncertainty = clock.uncertainty;
  camera.time_measured = clock.measured;
  camera.time_source = clock.source;
  if (!clip.camera->lens.is_pinhole())
    camera.removed_lenses.push_back({clip.camera->lens_model, clip.camera->lens});
  for (PreparedFrame& frame : scene.frames)
    if (frame.frame.camera_name == clip.name) {
      frame.frame.camera = prepared.camera;
      frame.mask_path = prepared.mask_path;
    }
  scene.cameras.push_back(std::move(camera));
  scene.sources.push_back({clip.video.filename().string(), clip_hash(clip)});
}

/// The conversions of all clips, each once.
void record_tone_map(const std::string& of_clip, PreparedScene& scene) {
  if (of_clip == "none" || scene.tone_map.find(of_clip) != std::string::npos) return;
  scene.tone_map = scene.tone_map == "none" ? of_clip : scene.tone_map + "; " + of_clip;
}

/// A few timesteps spread over the kept frames of the first clip, with each clip's nearest frame.
std::vector<RigInstant> spread_instants(const std::vector<std::vector<size_t>>& chosen,
                                        const std::vector<std::vector<double>>& timesteps,
                                        const TimeAxis& axis) {
  constexpr size_t kInstants = 4;
  std::vector<RigInstant> instants;
  const std::vector<size_t>& first = chosen.front();
  for (size_t k = 0; k < std::min(kInstants, first.size()); ++k) {
    const size_t index = first.size() <= kInstants ? k : k * (first.size() - 1) / (kInstants - 1);
    const double timestep = timesteps[0][first[index]];
    RigInstant instant{(timestep - axis.origin) / axis.duration, {}};
    for (const std::vector<double>& of_clip : timesteps) {
      const auto nearest = std::min_element(
          of_clip.begin(), of_clip.end(),
          [&](double a, double b) { return std::abs(a - timestep) < std::abs(b - timestep); });
      instant.frame.emplace_back(size_t(nearest - of_clip.begin()));
    }
    instants.push_back(std::move(instant));
  }
  return instants;
}

/// One camera whose poses are to be found.
Converted convert_moving(const Work& work, const RigClips& rig, IngestReport report) {
  Converted moving = [&] {
    try {
      return convert_moving_video(work.capture, rig.clips.front(), work.folder, work.options,
                                  work.progress);
    } catch (const InputError& error) {
      throw InputError(error.what() + reading_hint(work, rig));
    }
  }();
  moving.report.notes = std::move(report.notes);
  moving.report.warnings.insert(moving.report.warnings.begin(), report.warnings.begin(),
                                report.warnings.end());
  return moving;
}

}  // namespace

Converted convert_videos(const fs::path& capture, const fs::path& folder,
                         const IngestOptions& options, const IngestProgress& progress) {
  const Work work{capture, folder, options, progress};
  IngestReport report;
  RigClips rig = open_rig_clips(capture, options, report.warnings);
  if (options.layout == CaptureLayout::kSequences) report.notes.push_back(reading_of(work, rig));
  check_clips(capture, options, rig, report.warnings);
  if (!rig.posed && rig.clips.size() == 1) return convert_moving(work, rig, std::move(report));
  if (options.test_every && rig.clips.size() > 1)
    throw InputError(
        "--test-every is given, but of several cameras whole ones are held out; pass --held-out "
        "with their names");
  PointCloud points =
      rig.posed ? find_points(capture, "", report.warnings) : place_cameras(work, rig, report);
  const bool of_images = !rig.clips.front().images.empty();
  const ClipClocks clocks = synchronise(rig.clips, sync_of(of_images, options.sync), progress);
  report.warnings.insert(report.warnings.end(), clocks.warnings.begin(), clocks.warnings.end());
  if (rig.clips.size() > 1) report.notes.push_back(clock_note(rig.names(), clocks.clocks));
  const auto timesteps = rig_timesteps(rig, clocks);
  const auto chosen = kept_frames(capture, options, rig, timesteps, report.warnings);

  PreparedScene scene;
  scene.layout = of_images ? "sequences" : rig.posed ? "n3dv" : "videos";
  scene.scale = options.scale;
  scene.background = "opaque";
  std::vector<double> seconds;
  std::vector<ClipFrames> frames(rig.clips.size());
  for (size_t i = 0; i < rig.clips.size(); ++i)
    describe_frames(rig, i, chosen[i], timesteps[i], scene, frames[i], seconds);
  if (options.test_every) hold_out_frames(*options.test_every, scene);
  int64_t done = 0;
  for (size_t i = 0; i < rig.clips.size(); ++i) {
    const std::string doing = "decoding " + rig.clips[i].video.filename().string();
    const PreparedClip prepared = write_clip_images(rig.clips[i], frames[i], folder, options, [&] {
      progress(doing, ++done, int64_t(scene.frames.size()));
    });
    record_camera(rig.clips[i], clocks.clocks[i], prepared, scene);
    record_tone_map(prepared.tone_map, scene);
    if (prepared.has_alpha) scene.background = "alpha kept";
  }
  const bool one_instant = options.allow_static || options.frames == 1;
  const NormalisedTimes times = normalise_times(seconds, one_instant, capture.string());
  for (size_t i = 0; i < scene.frames.size(); ++i) scene.frames[i].frame.time = times.time[i];
  scene.time_axis = times.axis;
  scene.time_base = scene.cameras.front().time_base;
  scene.is_static = times.is_static;
  if (rig.posed && options.cloud == CloudDensity::kSparse && points.position.empty())
    points = triangulate_instants(rig.clips, rig.held_out,
                                  spread_instants(chosen, timesteps, times.axis),
                                  options.work / "points", options.poses, progress);
  for (const fs::path& file : rig.pose_files)
    scene.sources.push_back({file.filename().string(), source_hash(file)});
  report.frames = int64_t(scene.frames.size());
  report.cameras = int64_t(rig.clips.size());
  return {std::move(scene), std::move(points), std::move(report)};
}

}  // namespace tessera
