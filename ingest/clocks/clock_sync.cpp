// Chooses between stated offsets, container times, sound and motion, collects the warnings, and
// reads the file of stated offsets.
#include "ingest/clocks/clock_sync.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/clocks/offset_solver.h"
#include "ingest/clocks/sync_audio.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
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
    const ContainerClock& clock = *clip.timeline.clock;
    offsets.push_back(clock.since(*clips.front().timeline.clock));
    whole_seconds = whole_seconds && clock.seconds == std::floor(clock.seconds);
  }
  if (whole_seconds) {  // a date of creation, or timecodes without a fraction
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

/// Sound where motion confirms it or is less precise; motion where it contradicts.
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
  if (all_precise) return motion;  // they agree, and images have no delay by the speed of sound
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

using Offsets = std::map<std::string, double>;

Offsets from_json(const std::filesystem::path& path) {
  Offsets offsets;
  const nlohmann::json stated = read_json(path);
  for (const auto& [name, value] : stated.items())
    offsets[name] = *finite_number(stated, name.c_str(), path.string());
  return offsets;
}

/// "name seconds" or "name,seconds"; false for a line without content.
bool read_line(std::string line, const std::string& where, Offsets& offsets) {
  constexpr const char* kBlank = " \t\r,;";
  line = line.substr(0, line.find('#'));
  const size_t begin = line.find_first_not_of(kBlank);
  if (begin == std::string::npos) return false;
  const size_t end = line.find_last_not_of(kBlank) + 1;
  const size_t gap = line.find_last_of(kBlank, end - 1);
  double seconds = 0;
  bool good = gap != std::string::npos && gap > begin;
  if (good) {
    const char* const first = line.data() + gap + 1 + (line[gap + 1] == '+' ? 1 : 0);
    const auto parsed = std::from_chars(first, line.data() + end, seconds);
    good = parsed.ec == std::errc() && parsed.ptr == line.data() + end && std::isfinite(seconds);
  }
  if (!good)
    throw InputError(
        fmt::format("{}: is '{}', expected a camera and its offset in seconds, like "
                    "cam02 0.0417; correct this line",
                    where, line.substr(begin, end - begin)));
  const std::string name = line.substr(begin, line.find_last_not_of(kBlank, gap) + 1 - begin);
  if (!offsets.emplace(name, seconds).second)
    throw InputError(fmt::format("{}: states {} a second time; leave one of the two", where, name));
  return true;
}

Offsets from_text(const std::string& text, const std::string& path) {
  Offsets offsets;
  size_t number = 1;
  for (size_t position = 0; position < text.size(); ++number) {
    const size_t end = std::min(text.find('\n', position), text.size());
    read_line(text.substr(position, end - position), fmt::format("{}: line {}", path, number),
              offsets);
    position = end + 1;
  }
  return offsets;
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

std::vector<double> read_stated_offsets(const std::filesystem::path& path,
                                        const std::vector<std::string>& names) {
  const std::string text = read_plain_text(path);
  const size_t first = text.find_first_not_of(" \t\r\n");
  const Offsets offsets = first != std::string::npos && text[first] == '{'
                              ? from_json(path)
                              : from_text(text, path.string());
  for (const auto& [name, seconds] : offsets)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw InputError(
          fmt::format("{}: states an offset for '{}', but the cameras are {}; correct "
                      "or remove it",
                      path.string(), name, fmt::join(names, ", ")));
  std::vector<double> result;
  for (const std::string& name : names) {
    const auto found = offsets.find(name);
    if (found == offsets.end())
      throw InputError(fmt::format(
          "{}: states no offset for {}; add it, with 0 for a camera whose clock is right",
          path.string(), name));
    result.push_back(found->second);
  }
  return result;
}

}  // namespace tessera
