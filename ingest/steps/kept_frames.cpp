// Compares the clips with each other and with what was asked for, before and after their clocks are
// known.
#include "ingest/steps/kept_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/checks/odd_cameras.h"
#include "ingest/clocks/frame_rates.h"
#include "ingest/clocks/frame_window.h"
#include "ingest/clocks/shared_time.h"
#include "ingest/test_views.h"
#include "ingest/video/clip_mistakes.h"
#include "ingest/video/frame_colour.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr double kFrameAndHalf = 1.5;  // in frames; clocks that differ by one are no matter

/// Whatever the clocks are, what is kept is no longer than the longest clip: refused before COLMAP
/// has worked for minutes.
void check_start_of_longest(const Capture& capture, const IngestOptions& options) {
  TimeInterval longest;
  for (const RigClip& clip : capture.clips) {
    const VideoTimeline& timeline = clip.timeline;
    const double seconds = timeline.seconds(timeline.ticks.size() - 1) - timeline.seconds(0);
    longest.last = std::max(longest.last, seconds);
  }
  check_start({options.start, {}, {}, {}}, longest, capture.folder.string());
}

/// One line for all cameras of which `is` holds.
template <class Is>
void warn_of_cameras(const Is& is, const char* what, Capture& capture) {
  std::vector<std::string> names;
  for (const RigClip& clip : capture.clips)
    if (is(clip.timeline)) names.push_back(clip.name);
  if (!names.empty()) capture.warnings.push_back(fmt::format("{}: {}", listed_names(names), what));
}

/// What is lost as the cameras do not begin or end together.
void warn_of_ends(const std::vector<std::vector<double>>& timesteps, const TimeInterval& shared,
                  Capture& capture) {
  size_t begins = 0, ends = 0;  // the cameras with which `shared` begins and ends
  TimeInterval whole = shared;
  for (size_t i = 0; i < timesteps.size(); ++i) {
    whole.first = std::min(whole.first, timesteps[i].front());
    whole.last = std::max(whole.last, timesteps[i].back());
    if (timesteps[i].front() == shared.first) begins = i;
    if (timesteps[i].back() == shared.last) ends = i;
  }
  const double enough = kFrameAndHalf * capture.clips.front().timeline.frame_seconds;
  if (shared.first - whole.first > enough)
    capture.warnings.push_back(
        fmt::format("{} begins {:.3f} s after the first camera; frames before that are not used",
                    capture.clips[begins].video.filename().string(), shared.first - whole.first));
  if (whole.last - shared.last > enough)
    capture.warnings.push_back(fmt::format(
        "{} ends {:.3f} s before the last camera, at {:.3f} s; frames after that are not used",
        capture.clips[ends].video.filename().string(), whole.last - shared.last, shared.last));
}

/// The kept frames of some cameras, which have any.
TimeInterval interval_of(const std::vector<std::vector<size_t>>& kept,
                         const std::vector<std::vector<double>>& timesteps,
                         const std::vector<char>& of) {
  TimeInterval interval{INFINITY, -INFINITY};
  for (size_t i = 0; i < kept.size(); ++i) {
    if (!of[i]) continue;
    interval.first = std::min(interval.first, timesteps[i][kept[i].front()]);
    interval.last = std::max(interval.last, timesteps[i][kept[i].back()]);
  }
  return interval;
}

/// Cameras of which the rest of the clip is not seen. Those that begin late end with the others,
/// also where the window is so many frames.
void keep_parts(const SharedTime& shared, const std::vector<std::vector<double>>& timesteps,
                std::vector<std::vector<size_t>>& kept, Capture& capture) {
  const TimeInterval clip = interval_of(kept, timesteps, shared.films_all_of);
  std::vector<std::string> parts;
  for (size_t i = 0; i < kept.size(); ++i) {
    if (shared.films_all_of[i]) continue;
    const RigClip& camera = capture.clips[i];
    const double frame = camera.timeline.frame_seconds;
    std::erase_if(kept[i], [&](size_t k) { return timesteps[i][k] >= clip.last + frame / 2; });
    if (kept[i].empty()) continue;
    const double first = timesteps[i][kept[i].front()], last = timesteps[i][kept[i].back()];
    if (std::max(first - clip.first, clip.last - last) < kFrameAndHalf * frame) continue;
    capture.partial.push_back(camera.name);
    parts.push_back(fmt::format("{} ({:.3f} s)", camera.name, last - first));
  }
  if (!parts.empty())
    capture.warnings.push_back(
        fmt::format("{}: a part of the {:.3f} s of the clip; the other cameras alone show the rest",
                    listed_names(parts), clip.last - clip.first));
}

}  // namespace

void check_clips(Capture& capture, const IngestOptions& options) {
  check_start_of_longest(capture, options);
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
  const SharedTime shared = shared_time(timesteps, window);
  if (shared.interval.empty())
    throw InputError(fmt::format(
        "{}: the cameras have no timestep in common; state their clocks with --offsets, or leave "
        "some out with --cameras",
        capture.folder.string()));
  check_start(window, shared.interval, capture.folder.string());
  warn_of_ends(timesteps, shared.interval, capture);
  std::vector<std::vector<size_t>> kept;
  for (const std::vector<double>& of_clip : timesteps)
    kept.push_back(choose_frames(of_clip, window, shared.interval));
  keep_parts(shared, timesteps, kept, capture);
  for (size_t i = 0; i < kept.size(); ++i)
    if (kept[i].empty())
      throw InputError(fmt::format(
          "{}: has no frame between {:.3f} s and {:.3f} s, where other cameras have some; change "
          "--start, --duration or --fps, state the clocks with --offsets, or leave the camera out "
          "with --cameras",
          capture.clips[i].video.string(), shared.interval.first, shared.interval.last));
  return kept;
}

}  // namespace tessera
