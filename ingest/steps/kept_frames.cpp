// Compares the clips with each other and with what was asked for, before and after their clocks are
// known.
#include "ingest/steps/kept_frames.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/checks/odd_cameras.h"
#include "ingest/clocks/frame_rates.h"
#include "ingest/clocks/frame_window.h"
#include "ingest/clocks/limiting_cameras.h"
#include "ingest/test_views.h"
#include "ingest/video/clip_mistakes.h"
#include "ingest/video/frame_colour.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Whatever the clocks are and whichever cameras are left out, the common part of all clips is no
/// longer than the longest one: refused before COLMAP has worked for minutes.
void check_start_of_longest(const Capture& capture, const IngestOptions& options) {
  TimeInterval longest;
  for (const RigClip& clip : capture.clips) {
    const VideoTimeline& timeline = clip.timeline;
    const double seconds = timeline.seconds(timeline.ticks.size() - 1) - timeline.seconds(0);
    longest.last = std::max(longest.last, seconds);
  }
  check_start({options.start, {}, {}, {}}, longest, capture.folder.string());
}

/// A camera that is too short whatever the clocks are is refused before COLMAP has worked for
/// minutes. Where the clocks are not known yet, the clips are compared as if all began together.
void check_lengths(const Capture& capture, const IngestOptions& options) {
  const SyncOptions& sync = options.sync;
  if (capture.posed || !sync.offsets.empty()) return;
  const bool one_clock = sync.method == SyncMethod::kNone;
  std::vector<std::vector<double>> seconds;
  for (const RigClip& clip : capture.clips) {
    const double origin = one_clock ? 0 : clip.timeline.seconds(0);
    std::vector<double>& of_clip = seconds.emplace_back();
    for (size_t k = 0; k < clip.timeline.ticks.size(); ++k)
      of_clip.push_back(clip.timeline.seconds(k) - origin);
  }
  limit_warning(
      limited_clip(clip_names(capture), seconds,
                   FrameWindow{options.start, options.duration, options.fps, options.frames}),
      capture.folder.string());
}

/// One line for all cameras of which `is` holds.
template <class Is>
void warn_of_cameras(const Is& is, const char* what, Capture& capture) {
  std::vector<std::string> names;
  for (const RigClip& clip : capture.clips)
    if (is(clip.timeline)) names.push_back(clip.name);
  if (!names.empty()) capture.warnings.push_back(fmt::format("{}: {}", listed_names(names), what));
}

/// Where no camera limits the clip more than others: what is lost as they do not begin or end
/// together.
void warn_of_ends(const std::vector<std::vector<double>>& timesteps, const TimeInterval& common,
                  Capture& capture) {
  size_t begins_last = 0, ends_first = 0;
  TimeInterval whole{timesteps[0].front(), timesteps[0].back()};
  for (size_t i = 0; i < timesteps.size(); ++i) {
    whole.first = std::min(whole.first, timesteps[i].front());
    whole.last = std::max(whole.last, timesteps[i].back());
    if (timesteps[i].front() > timesteps[begins_last].front()) begins_last = i;
    if (timesteps[i].back() < timesteps[ends_first].back()) ends_first = i;
  }
  const double enough = 1.5 * capture.clips.front().timeline.frame_seconds;
  if (common.first - whole.first > enough)
    capture.warnings.push_back(fmt::format(
        "{} begins {:.3f} s after the first camera; frames before that are not used",
        capture.clips[begins_last].video.filename().string(), common.first - whole.first));
  if (whole.last - common.last > enough)
    capture.warnings.push_back(fmt::format(
        "{} ends {:.3f} s before the last camera, at {:.3f} s; frames after that are not used",
        capture.clips[ends_first].video.filename().string(), whole.last - common.last,
        common.last));
}

}  // namespace

void check_clips(Capture& capture, const IngestOptions& options) {
  check_start_of_longest(capture, options);
  check_lengths(capture, options);
  const std::vector<std::string> names = clip_names(capture);
  std::vector<double> frame_seconds;
  std::vector<std::string> colours;
  for (const RigClip& clip : capture.clips) {
    frame_seconds.push_back(clip.timeline.frame_seconds);
    colours.push_back(colour_name(clip.timeline.colour));
  }
  std::vector<std::string> lines = copied_clips(capture.clips);
  if (const std::string odd = odd_cameras(names, rate_texts(frame_seconds), "has"); !odd.empty())
    lines.push_back(odd +
                    ": each frame keeps its own time, but fewer timesteps are seen by all "
                    "cameras; film at one rate");
  if (options.fps) lines.push_back(fps_warning(*options.fps, frame_seconds));
  if (const std::string odd = odd_cameras(names, colours, "is"); !odd.empty())
    lines.push_back(odd +
                    ": all become sRGB, but cameras render what they film in different ways; "
                    "film with one setting");
  if (options.sync.offsets.empty()) lines.push_back(shifted_numbers(capture.clips));
  for (std::string& line : lines)
    if (!line.empty()) capture.warnings.push_back(std::move(line));
  warn_of_cameras([](const VideoTimeline& clip) { return clip.colour.interlaced; },
                  "frames are interlaced: they mix the lines of two times, so moving things have "
                  "combs; deinterlace with `ffmpeg -i IN -vf bwdif -crf 12 OUT`",
                  capture);
  warn_of_cameras([](const VideoTimeline& clip) { return clip.has_alpha; },
                  "alpha is not read, so that what lies below it is trained; export the frames as "
                  "PNG, which keep it",
                  capture);
}

std::vector<std::vector<size_t>> kept_frames(Capture& capture, const FrameWindow& window,
                                             const std::vector<std::vector<double>>& timesteps) {
  const TimeInterval common = common_interval(timesteps);
  LimitedClip clip = limited_clip(clip_names(capture), timesteps, window);
  const std::string limited = limit_warning(clip, capture.folder.string());
  capture.limiting = std::move(clip.limiting);
  if (common.empty())
    throw InputError(fmt::format(
        "{}: the cameras have no timestep in common; state their clocks with --offsets, or leave "
        "some out with --cameras",
        capture.folder.string()));
  check_start(window, common, capture.folder.string());
  if (limited.empty())
    warn_of_ends(timesteps, common, capture);
  else
    capture.warnings.push_back(limited);
  std::vector<std::vector<size_t>> chosen;
  for (size_t i = 0; i < capture.clips.size(); ++i) {
    chosen.push_back(choose_frames(timesteps[i], window, common));
    if (chosen.back().empty())
      throw InputError(fmt::format(
          "{}: has no frame between {:.3f} s and {:.3f} s, where all cameras have some; change "
          "--start, --duration or --fps, state the clocks with --offsets, or leave the camera out "
          "with --cameras",
          capture.clips[i].video.string(), common.first, common.last));
  }
  return chosen;
}

}  // namespace tessera
