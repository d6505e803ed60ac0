// Reads the packets once, with the edit lists applied by libavformat, and the timecode and creation
// time from the tags of the container.
#include "ingest/video/video_timeline.h"

extern "C" {
#include <libavutil/parseutils.h>
#include <libavutil/pixdesc.h>
#include <libavutil/timecode.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/video/frame_colour.h"
#include "ingest/video/frame_timing.h"
#include "ingest/video/video_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Presentation times of the shown frames as the packets come: in order of decoding.
std::vector<int64_t> shown_ticks(VideoFile& file) {
  const LibavOwned<AVPacket> packet = new_packet();
  std::vector<int64_t> ticks;
  std::optional<int64_t> first;  // a file cut in a group has frames before it without references
  while (file.read(*packet) == VideoFile::Read::kPacket) {
    if (!first) first = packet->pts;
    if ((packet->flags & AV_PKT_FLAG_DISCARD) == 0 && packet->pts >= *first)
      ticks.push_back(packet->pts);
  }
  return ticks;
}

/// Sorts, and takes out the times that are there already; returns those.
std::vector<int64_t> take_repeated(std::vector<int64_t>& ticks) {
  std::sort(ticks.begin(), ticks.end());
  std::vector<int64_t> once, repeated;
  for (const int64_t tick : ticks)
    (once.empty() || tick > once.back() ? once : repeated).push_back(tick);
  ticks = std::move(once);
  return repeated;
}

bool has_audio(const AVFormatContext& format) {
  for (unsigned i = 0; i < format.nb_streams; ++i)
    if (format.streams[i]->codecpar->codec_type == AVMEDIA_TYPE_AUDIO) return true;
  return false;
}

/// A tag of the video track, of the file, or of another track (MP4's timecode track).
std::optional<std::string> find_tag(const VideoFile& file, const char* name) {
  const AVFormatContext& format = file.format();
  if (const auto* tag = av_dict_get(file.track().metadata, name, nullptr, 0)) return tag->value;
  if (const auto* tag = av_dict_get(format.metadata, name, nullptr, 0)) return tag->value;
  for (unsigned i = 0; i < format.nb_streams; ++i)
    if (const auto* tag = av_dict_get(format.streams[i]->metadata, name, nullptr, 0))
      return tag->value;
  return std::nullopt;
}

/// The rate that timecodes count at: of the grid of frames, also where some are missing.
/// libavformat guesses that grid, at times as fine as the clock; the mean rate is the second
/// choice.
AVRational frame_rate(const AVStream& track, double median_seconds) {
  for (const AVRational rate : {track.r_frame_rate, track.avg_frame_rate})
    if (rate.num > 0 && std::abs(av_q2d(rate) * median_seconds - 1) < 0.25) return rate;
  return {0, 1};
}

}  // namespace

VideoTimeline read_timeline(const std::filesystem::path& path) {
  VideoFile file(path);
  VideoTimeline timeline;
  timeline.width = file.width();
  timeline.quarter_turns = file.quarter_turns();
  timeline.height = file.height();
  timeline.pixel_aspect = file.pixel_aspect();
  timeline.time_base = file.time_base();
  timeline.colour = colour_of(*file.track().codecpar);
  if (const std::string refusal = colour_refusal(timeline.colour); !refusal.empty())
    throw InputError(fmt::format("{}: {}", file.name(), refusal));
  timeline.has_audio = has_audio(file.format());
  timeline.ticks = shown_ticks(file);
  const std::string& cut = file.cut_reason();
  if (timeline.ticks.empty())
    throw InputError(fmt::format("{}: camera {} holds no frame{}; copy or encode this video again",
                                 file.name(), file.camera(), cut.empty() ? "" : " (" + cut + ")"));
  const std::vector<int64_t> repeated = take_repeated(timeline.ticks);
  const int64_t median = median_distance(timeline.ticks);
  timeline.frame_seconds = timeline.time_base.at(median);
  timeline.clock = container_clock(file, timeline.ticks.front(), median);

  const std::string camera = fmt::format("{}: camera {}", file.name(), file.camera());
  const auto add = [&](std::vector<std::string> lines) {
    timeline.warnings.insert(timeline.warnings.end(), lines.begin(), lines.end());
  };
  timeline.truncated = !cut.empty();
  if (timeline.truncated)
    timeline.warnings.push_back(fmt::format("{} is truncated after {} frames at {:.3f} s ({})",
                                            camera, timeline.ticks.size(),
                                            timeline.seconds(timeline.ticks.size() - 1), cut));
  add(gap_warnings(camera, timeline.ticks, timeline.time_base));
  add(duplicate_warnings(camera, repeated, timeline.time_base));
  const AVPixFmtDescriptor* const pixels =
      av_pix_fmt_desc_get(AVPixelFormat(file.track().codecpar->format));
  timeline.has_alpha = pixels != nullptr && (pixels->flags & AV_PIX_FMT_FLAG_ALPHA) != 0;
  return timeline;
}

Rational timecode_rate(const Rational& frames, double counts) {
  if (!(counts > 0) || frames.denominator <= 0) return frames;
  const double ratio = double(frames.numerator) / (double(frames.denominator) * counts);
  const auto whole = int64_t(std::lround(ratio));
  if (whole < 2 || std::abs(ratio / double(whole) - 1) > 0.01) return frames;
  return {frames.numerator, frames.denominator * whole};
}

std::optional<ContainerClock> timecode_clock(const std::string& timecode, const Rational& rate) {
  if (rate.numerator <= 0 || rate.denominator <= 0) return std::nullopt;
  const AVRational frames{int(rate.numerator), int(rate.denominator)};
  const auto seconds_of = [&](const std::string& text) -> std::optional<double> {
    AVTimecode read{};
    if (av_timecode_init_from_string(&read, frames, text.c_str(), nullptr) < 0) return std::nullopt;
    return double(read.start) * double(rate.denominator) / double(rate.numerator);
  };
  const auto seconds = seconds_of(timecode);
  if (!seconds) return std::nullopt;
  const bool drops = timecode.find_first_of(";.") != std::string::npos;
  return ContainerClock{*seconds, seconds_of(drops ? "24:00:00;00" : "24:00:00:00").value_or(0)};
}

std::optional<double> creation_seconds(const std::string& creation_time) {
  const size_t point = creation_time.rfind('.');
  if (point == std::string::npos ||
      creation_time.find_first_of("123456789", point) == std::string::npos)
    return std::nullopt;
  int64_t microseconds = 0;
  if (av_parse_time(&microseconds, creation_time.c_str(), 0) < 0) return std::nullopt;
  return double(microseconds) * 1e-6;
}

std::optional<ContainerClock> container_clock(const VideoFile& file, int64_t first_ticks,
                                              int64_t median_ticks) {
  const AVRational frames = frame_rate(file.track(), file.seconds(median_ticks));
  Rational rate{frames.num, frames.den};
  const AVFormatContext& format = file.format();
  for (unsigned i = 0; i < format.nb_streams; ++i)
    if (format.streams[i]->codecpar->codec_tag == MKTAG('t', 'm', 'c', 'd'))
      rate = timecode_rate(rate, av_q2d(format.streams[i]->avg_frame_rate));
  if (const auto timecode = find_tag(file, "timecode"))
    if (const auto clock = timecode_clock(*timecode, rate))
      return ContainerClock{clock->seconds - file.seconds(first_ticks), clock->day};
  if (const auto created = find_tag(file, "creation_time"))
    if (const auto seconds = creation_seconds(*created)) return ContainerClock{*seconds};
  return std::nullopt;
}

}  // namespace tessera
