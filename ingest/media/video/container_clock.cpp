// What: the tags that libavformat makes of each container's fields; libavutil reads their values.
// Not: a choice between cameras: each states its own.
#include "ingest/media/video/container_clock.h"

extern "C" {
#include <libavutil/parseutils.h>
#include <libavutil/timecode.h>
}

#include <cmath>

#include "ingest/media/video/video_file.h"

namespace tessera {
namespace {

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

std::optional<double> timecode_seconds(const std::string& timecode, const Rational& rate) {
  if (rate.numerator <= 0 || rate.denominator <= 0) return std::nullopt;
  AVTimecode read{};
  const AVRational frames{int(rate.numerator), int(rate.denominator)};
  if (av_timecode_init_from_string(&read, frames, timecode.c_str(), nullptr) < 0)
    return std::nullopt;
  return double(read.start) * double(rate.denominator) / double(rate.numerator);
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

std::optional<double> container_clock(const VideoFile& file, int64_t first_ticks,
                                      int64_t median_ticks) {
  const AVRational rate = frame_rate(file.track(), file.seconds(median_ticks));
  if (const auto timecode = find_tag(file, "timecode"))
    if (const auto seconds = timecode_seconds(*timecode, {rate.num, rate.den}))
      return *seconds - file.seconds(first_ticks);
  if (const auto created = find_tag(file, "creation_time")) return creation_seconds(*created);
  return std::nullopt;
}

}  // namespace tessera
