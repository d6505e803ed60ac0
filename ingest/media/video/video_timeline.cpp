// What: one pass over the packets; libavformat has applied the edit lists.
// Not: a guess: frames that no packet announces do not exist.
#include "ingest/media/video/video_timeline.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/clocks/frame_timing.h"
#include "ingest/media/video/container_clock.h"
#include "ingest/media/video/video_file.h"
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

}  // namespace

VideoTimeline read_timeline(const std::filesystem::path& path) {
  VideoFile file(path);
  VideoTimeline timeline;
  timeline.width = file.width();
  timeline.height = file.height();
  timeline.time_base = file.time_base();
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
  return timeline;
}

}  // namespace tessera
