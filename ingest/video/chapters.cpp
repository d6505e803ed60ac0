// Ticks of a chapter are shifted; wanted frames are decoded chapter by chapter.
#include "ingest/video/chapters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/video/video_timeline.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

std::string shape_of(const VideoTimeline& timeline) {
  return fmt::format("{}x{}, {:.3f} frames/s, {} {}", timeline.width, timeline.height,
                     timeline.frame_seconds > 0 ? 1 / timeline.frame_seconds : 0,
                     timeline.colour.transfer_name, timeline.colour.matrix_name);
}

void require_alike(const RigClip& clip, const VideoTimeline& first, const fs::path& file,
                   const VideoTimeline& next) {
  constexpr double kRates = 0.01;  // relative difference of what is one rate
  const bool one_rate = first.frame_seconds == 0 || next.frame_seconds == 0 ||
                        std::abs(next.frame_seconds / first.frame_seconds - 1) < kRates;
  if (first.width == next.width && first.height == next.height && one_rate &&
      first.time_base.numerator == next.time_base.numerator &&
      first.time_base.denominator == next.time_base.denominator &&
      first.colour.transfer == next.colour.transfer &&
      first.colour.primaries == next.colour.primaries)
    return;
  throw InputError(fmt::format(
      "{}: is no chapter of the recording that {} begins ({} after {}, time bases 1/{} and 1/{}); "
      "take it out, or encode all chapters of camera {} as one file",
      file.string(), clip.video.filename().string(), shape_of(next), shape_of(first),
      next.time_base.denominator, first.time_base.denominator, clip.name));
}

/// A line where the containers' clocks state another distance of the chapters than `shift`.
std::string clock_warning(const VideoTimeline& whole, const VideoTimeline& next, int64_t shift,
                          const fs::path& file) {
  if (!whole.clock || !next.clock || whole.clock->seconds == next.clock->seconds) return "";
  const double gap = next.clock->since(*whole.clock) - whole.time_base.at(shift);
  if (std::abs(gap) < 1.5 * whole.frame_seconds) return "";
  return fmt::format(
      "{}: begins {:.3f} s {} the chapter before it ends, by their clocks; it is joined to it "
      "without a gap",
      file.string(), std::abs(gap), gap > 0 ? "after" : "before");
}

void append(const RigClip& clip, const fs::path& file, VideoTimeline& whole) {
  if (whole.truncated)
    throw InputError(fmt::format("{}, and {} follows it; copy or encode that chapter again",
                                 whole.warnings.front(), file.filename().string()));
  VideoTimeline next = read_timeline(file);
  require_alike(clip, whole, file, next);
  const int64_t median = median_distance(whole.ticks.size() > 1 ? whole.ticks : next.ticks);
  const int64_t shift = whole.ticks.back() + std::max<int64_t>(1, median) - next.ticks.front();
  whole.chapters.push_back({next.ticks.front() + shift, shift});
  for (const int64_t ticks : next.ticks) whole.ticks.push_back(ticks + shift);
  whole.truncated = next.truncated;
  whole.has_audio = whole.has_audio && next.has_audio;
  if (const std::string line = clock_warning(whole, next, shift, file); !line.empty())
    next.warnings.push_back(line);
  whole.warnings.insert(whole.warnings.begin(), next.warnings.begin(), next.warnings.end());
}

}  // namespace

VideoTimeline joined_timeline(const RigClip& clip) {
  VideoTimeline whole = read_timeline(clip.video);
  for (const fs::path& chapter : clip.chapters) append(clip, chapter, whole);
  return whole;
}

void decode_chapters(const RigClip& clip, const std::vector<int64_t>& wanted,
                     const std::function<bool(VideoFrame)>& on_frame,
                     const DecodeOptions& options) {
  const std::vector<ChapterStart>& starts = clip.timeline.chapters;
  bool more = true;
  auto begin = wanted.begin();
  for (size_t i = 0; more && begin != wanted.end() && i <= starts.size(); ++i) {
    const auto end =
        i < starts.size() ? std::lower_bound(begin, wanted.end(), starts[i].first) : wanted.end();
    const int64_t shift = i > 0 ? starts[i - 1].shift : 0;
    std::vector<int64_t> of_file(begin, end);
    for (int64_t& ticks : of_file) ticks -= shift;
    begin = end;
    if (of_file.empty()) continue;
    decode_frames(
        i > 0 ? clip.chapters[i - 1] : clip.video, of_file,
        [&](VideoFrame frame) {
          frame.ticks += shift;
          return more = on_frame(std::move(frame));
        },
        options);
  }
}

}  // namespace tessera
