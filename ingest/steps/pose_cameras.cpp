// Hands the clips to COLMAP, and says what it found.
#include <fmt/format.h>

#include <algorithm>

#include "ingest/checks/orientation.h"
#include "ingest/colmap/pose_estimation.h"
#include "ingest/steps/left_out_clips.h"
#include "ingest/steps/pose_hints.h"
#include "ingest/steps/steps.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

PoseEstimate estimate_of(const Capture& capture, const StepContext& context) {
  const IngestOptions& options = context.options;
  try {
    std::optional<std::vector<char>> held_out;
    if (!capture.held_out.empty()) held_out = capture.held_out;
    return estimate_rig(capture.clips, held_out, options.work / "colmap", options.poses,
                        context.progress);
  } catch (const InputError& error) {
    throw InputError(error.what() + pose_hints(capture));
  }
}

}  // namespace

Capture pose_cameras(Capture capture, const StepContext& context) {
  if (capture.clips.size() < 2 || capture.posed) return capture;
  PoseEstimate estimate = estimate_of(capture, context);
  capture.warnings.insert(capture.warnings.end(), estimate.warnings.begin(),
                          estimate.warnings.end());
  std::vector<char> placed;
  for (size_t i = 0; i < capture.clips.size(); ++i) {
    capture.clips[i].camera = std::move(estimate.cameras[i]);
    placed.push_back(capture.clips[i].camera.has_value());
  }
  capture.notes.push_back(
      fmt::format("COLMAP registered {} of {} cameras, mean reprojection error {:.2f} pixels{}",
                  std::count(placed.begin(), placed.end(), 1), placed.size(), estimate.error,
                  estimate.reused ? kReused : ""));
  capture.held_out = std::move(estimate.held_out);
  keep_clips(capture, placed);
  leave_out_bad_lenses(context.options, capture);
  if (std::all_of(capture.held_out.begin(), capture.held_out.end(), [](char held) { return held; }))
    throw InputError(fmt::format(
        "{}: only held-out cameras could be placed, none is left to train on; name others with "
        "--held-out",
        capture.folder.string()));
  capture.points = std::move(estimate.points);
  capture.posed = true;
  return capture;
}

std::string pose_hints(const Capture& capture) {
  std::vector<std::pair<int, int>> sizes;
  for (const RigClip& clip : capture.clips)
    sizes.emplace_back(clip.timeline.width, clip.timeline.height);
  std::string hints;
  if (const std::string mixed = mixed_orientation(clip_names(capture), sizes); !mixed.empty())
    hints += "; " + mixed + ": check whether their videos lack a rotation flag";
  if (!capture.unused_poses.empty()) hints += "; " + capture.unused_poses;
  if (!capture.notes.empty()) hints += "; " + capture.notes.front();  // how it is read
  return hints;
}

}  // namespace tessera
