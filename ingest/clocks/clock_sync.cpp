// What: the choice between stated offsets, container times, sound and motion, and its warnings.
// Not: how each of them measures (stated_offsets.h, sync_audio.h, sync_motion.h).
#include "ingest/clocks/clock_sync.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ingest/clocks/offset_solver.h"
#include "ingest/clocks/stated_offsets.h"
#include "ingest/clocks/sync_audio.h"
#include "ingest/clocks/sync_motion.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr const char* kOtherMethods = "use another --sync or state the clocks with --offsets FILE";

ClipClocks unchanged(const std::vector<RigClip>& clips) {
  return {std::vector<ClipClock>(clips.size(), {0, 0, 0, "none"}), {}};
}

ClipClocks stated(const std::vector<RigClip>& clips, const std::filesystem::path& path) {
  std::vector<std::string> names;
  for (const RigClip& clip : clips) names.push_back(clip.name);
  ClipClocks result;
  for (const double offset : read_stated_offsets(path, names))
    result.clocks.push_back({offset, offset, 0, "stated"});
  return result;
}

/// Whether there is a timestep that all clips show.
bool overlap(const std::vector<RigClip>& clips, const std::vector<ClipClock>& clocks) {
  double latest = -std::numeric_limits<double>::infinity(), earliest = -latest;
  for (size_t i = 0; i < clips.size(); ++i) {
    const VideoTimeline& timeline = clips[i].timeline;
    if (timeline.ticks.empty()) continue;
    latest = std::max(latest, timeline.seconds(0) + clocks[i].offset);
    earliest = std::min(earliest, timeline.seconds(timeline.ticks.size() - 1) + clocks[i].offset);
  }
  return latest <= earliest;
}

/// Nothing, with the reason, where the containers do not state the clips' common clock.
std::optional<std::vector<ClipClock>> from_containers(const std::vector<RigClip>& clips,
                                                      std::string& reason) {
  std::vector<double> offsets;
  bool whole_seconds = true;
  for (const RigClip& clip : clips) {
    if (!clip.timeline.clock) {
      reason = fmt::format("{}: its container states no time", clip.name);
      return std::nullopt;
    }
    offsets.push_back(*clip.timeline.clock);
    whole_seconds = whole_seconds && offsets.back() == std::floor(offsets.back());
  }
  if (whole_seconds) {  // a date of creation, or timecodes that tell nothing apart
    reason = fmt::format("{}: its container, like all others, states its time in whole seconds",
                         clips.front().name);
    return std::nullopt;
  }
  const double middle = median_offset(offsets);
  std::vector<ClipClock> clocks;
  for (size_t i = 0; i < clips.size(); ++i) {
    const double offset = offsets[i] - middle;  // timecodes count frames: an even spread of one
    clocks.push_back(
        {offset, offset, clips[i].timeline.frame_seconds / std::sqrt(12.0), "container"});
  }
  if (!overlap(clips, clocks)) {
    reason =
        fmt::format("{}: by the containers' times the clips do not overlap", clips.front().name);
    return std::nullopt;
  }
  return clocks;
}

/// True where motion was measured to a quarter of a frame.
bool precise(const ClipClock& motion, const RigClip& clip) {
  return motion.source == "motion" && motion.uncertainty < 0.25 * clip.timeline.frame_seconds;
}

/// Sound that motion has confirmed, or does not know better; motion where it contradicts.
ClipClocks sound_or_motion(const std::vector<RigClip>& clips, const std::vector<ClipClock>& sound,
                           ClipClocks motion) {
  bool all_precise = true;
  for (size_t i = 0; i < clips.size(); ++i) {
    all_precise = all_precise && precise(motion.clocks[i], clips[i]);
    if (!precise(motion.clocks[i], clips[i])) continue;
    const double apart = std::abs(sound[i].offset - motion.clocks[i].offset);
    const double error = std::hypot(sound[i].uncertainty, motion.clocks[i].uncertainty);
    if (apart < 3 * error + 0.5 * clips[i].timeline.frame_seconds) continue;
    motion.warnings.push_back(fmt::format(
        "{}: its sound puts its clock {:+.3f} s off, its images {:+.3f} s; the sound is not "
        "used: state the clocks with --offsets FILE if the images mislead",
        clips[i].name, sound[i].offset, motion.clocks[i].offset));
    return motion;
  }
  if (all_precise) return motion;  // they agree, and images do not hear the way of the sound
  return {sound, {}};
}

ClipClocks automatic(const std::vector<RigClip>& clips, const IngestProgress& progress) {
  std::string reason;
  if (auto clocks = from_containers(clips, reason)) return {*clocks, {}};
  const bool all_sound = std::all_of(clips.begin(), clips.end(),
                                     [](const RigClip& clip) { return clip.timeline.has_audio; });
  const auto sound = all_sound ? synchronise_by_audio(clips, progress, reason) : std::nullopt;
  ClipClocks motion = synchronise_by_motion(clips, progress);
  if (sound) return sound_or_motion(clips, *sound, std::move(motion));
  if (all_sound) motion.warnings.push_back(reason + ", so the images' motion is used");
  return motion;
}

}  // namespace

ClipClocks synchronise(const std::vector<RigClip>& clips, const SyncOptions& options,
                       const IngestProgress& progress) {
  if (!options.offsets.empty()) return stated(clips, options.offsets);
  if (clips.size() < 2 || options.method == SyncMethod::kNone) return unchanged(clips);
  std::string reason;
  std::optional<std::vector<ClipClock>> clocks;
  switch (options.method) {
    case SyncMethod::kContainer:
      clocks = from_containers(clips, reason);
      break;
    case SyncMethod::kAudio:
      clocks = synchronise_by_audio(clips, progress, reason);
      break;
    case SyncMethod::kMotion:
      return synchronise_by_motion(clips, progress);
    case SyncMethod::kAuto:
    case SyncMethod::kNone:
      return automatic(clips, progress);
  }
  if (!clocks) throw InputError(fmt::format("{}; {}", reason, kOtherMethods));
  return {*clocks, {}};
}

}  // namespace tessera
