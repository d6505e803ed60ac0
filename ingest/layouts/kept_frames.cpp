// Compares the clips with each other and with what was asked for, before and after their clocks are
// known.
#include "ingest/layouts/kept_frames.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/checks/mixed_colours.h"
#include "ingest/clocks/frame_rates.h"
#include "ingest/clocks/frame_window.h"
#include "ingest/clocks/limiting_cameras.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

FrameWindow window_of(const IngestOptions& o) {
  return {o.start, o.duration, o.fps, o.frames};
}

/// Whatever the clocks are and whichever cameras are left out, the common part of all clips is no
/// longer than the longest one: refused before COLMAP has worked for minutes.
void check_start_of_longest(const fs::path& capture, const IngestOptions& options,
                            const RigClips& rig) {
  TimeInterval longest;
  for (const RigClip& clip : rig.clips) {
    const VideoTimeline& timeline = clip.timeline;
    const double seconds = timeline.seconds(timeline.ticks.size() - 1) - timeline.seconds(0);
    longest.last = std::max(longest.last, seconds);
  }
  check_start({options.start, {}, {}, {}}, longest, capture.string());
}

/// A camera that is too short whatever the clocks are is refused before COLMAP has worked for
/// minutes. Where the clocks are not known yet, the clips are compared as if all began together.
void check_lengths(const fs::path& capture, const IngestOptions& options, const RigClips& rig) {
  const SyncOptions& sync = options.sync;
  if (rig.posed || !sync.offsets.empty()) return;
  const bool of_images = !rig.clips.front().images.empty();
  const bool one_clock =
      sync.method == SyncMethod::kNone || (of_images && sync.method == SyncMethod::kAuto);
  std::vector<std::vector<double>> seconds;
  for (const RigClip& clip : rig.clips) {
    const double origin = one_clock ? 0 : clip.timeline.seconds(0);
    std::vector<double>& of_clip = seconds.emplace_back();
    for (size_t k = 0; k < clip.timeline.ticks.size(); ++k)
      of_clip.push_back(clip.timeline.seconds(k) - origin);
  }
  limit_warning(limited_clip(rig.names(), seconds, window_of(options)), capture.string());
}

void warn_of_rates(const RigClips& rig, std::vector<std::string>& warnings) {
  std::vector<double> frame_seconds;
  for (const RigClip& clip : rig.clips) frame_seconds.push_back(clip.timeline.frame_seconds);
  const std::string warning = rate_warning(rig.names(), frame_seconds);
  if (!warning.empty()) warnings.push_back(warning);
}

void warn_of_colours(const RigClips& rig, std::vector<std::string>& warnings) {
  std::vector<FrameColour> colours;
  for (const RigClip& clip : rig.clips) colours.push_back(clip.timeline.colour);
  const std::string warning = mixed_colours(rig.names(), colours);
  if (!warning.empty()) warnings.push_back(warning);
}

/// Where no camera limits the clip more than others: what is lost as they do not begin or end
/// together.
void warn_of_ends(const RigClips& rig, const std::vector<std::vector<double>>& timesteps,
                  const TimeInterval& common, std::vector<std::string>& warnings) {
  size_t begins_last = 0, ends_first = 0;
  TimeInterval whole{timesteps[0].front(), timesteps[0].back()};
  for (size_t i = 0; i < timesteps.size(); ++i) {
    whole.first = std::min(whole.first, timesteps[i].front());
    whole.last = std::max(whole.last, timesteps[i].back());
    if (timesteps[i].front() > timesteps[begins_last].front()) begins_last = i;
    if (timesteps[i].back() < timesteps[ends_first].back()) ends_first = i;
  }
  const double enough = 1.5 * rig.clips.front().timeline.frame_seconds;
  if (common.first - whole.first > enough)
    warnings.push_back(
        fmt::format("{} begins {:.3f} s after the first camera; frames before that are not used",
                    rig.clips[begins_last].video.filename().string(), common.first - whole.first));
  if (whole.last - common.last > enough)
    warnings.push_back(fmt::format(
        "{} ends {:.3f} s before the last camera, at {:.3f} s; frames after that are not used",
        rig.clips[ends_first].video.filename().string(), whole.last - common.last, common.last));
}

}  // namespace

void check_clips(const fs::path& capture, const IngestOptions& options, const RigClips& rig,
                 std::vector<std::string>& warnings) {
  check_start_of_longest(capture, options, rig);
  check_lengths(capture, options, rig);
  warn_of_rates(rig, warnings);
  warn_of_colours(rig, warnings);
}

std::vector<std::vector<size_t>> kept_frames(const fs::path& capture, const IngestOptions& options,
                                             const RigClips& rig,
                                             const std::vector<std::vector<double>>& timesteps,
                                             std::vector<std::string>& warnings) {
  const FrameWindow window = window_of(options);
  const TimeInterval common = common_interval(timesteps);
  const std::string limited =
      limit_warning(limited_clip(rig.names(), timesteps, window), capture.string());
  if (common.empty())
    throw InputError(fmt::format(
        "{}: the cameras have no timestep in common; state their clocks with --offsets, or leave "
        "some out with --cameras",
        capture.string()));
  check_start(window, common, capture.string());
  if (limited.empty())
    warn_of_ends(rig, timesteps, common, warnings);
  else
    warnings.push_back(limited);
  std::vector<std::vector<size_t>> chosen;
  for (size_t i = 0; i < rig.clips.size(); ++i) {
    chosen.push_back(choose_frames(timesteps[i], window, common));
    if (chosen.back().empty())
      throw InputError(fmt::format(
          "{}: has no frame between {:.3f} s and {:.3f} s, where all cameras have some; change "
          "--start, --duration or --fps, state the clocks with --offsets, or leave the camera out "
          "with --cameras",
          rig.clips[i].video.string(), common.first, common.last));
  }
  return chosen;
}

}  // namespace tessera
