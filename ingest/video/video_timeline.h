// The presentation times of the frames of a video and the defects of its clock, without decoding.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/video/frame_colour.h"
#include "ingest/video/frame_timing.h"

namespace tessera {

struct VideoTimeline {
  int width = 0, height = 0;    // of the upright image: a rotation flag is undone
  Rational time_base;           // seconds a tick
  std::vector<int64_t> ticks;   // presentation times of the frames that are shown, increasing
  double frame_seconds = 0;     // median distance of two frames; 0 for one frame
  std::optional<double> clock;  // container time of tick 0, seconds since any common origin
                                // (timecode, creation time); absent where it states none
  FrameColour colour;           // as the container and the headers state it
  bool has_audio = false;
  bool truncated = false;  // the file ends before what it states; `ticks` are what is there
  std::vector<std::string> warnings;  // each with the file: gaps, duplicates, truncation, with
                                      // seconds, and interlaced frames

  double seconds(size_t frame) const { return time_base.at(ticks[frame]); }
};

/// Errors: InputError naming the file: no video in it, without presentation times, no frame,
/// colours that have no conversion to sRGB (frame_colour.h).
VideoTimeline read_timeline(const std::filesystem::path& path);

class VideoFile;

/// Seconds of a timecode HH:MM:SS:FF (drop-frame with ; before FF) counted at `rate` frames/s.
std::optional<double> timecode_seconds(const std::string& timecode, const Rational& rate);
/// Seconds since 1970 of a creation time with digits below the second that are not all 0.
std::optional<double> creation_seconds(const std::string& creation_time);

/// The time at tick 0. A timecode is that of the first frame shown, at `first_ticks`; a creation
/// time is that of tick 0. `median_ticks`: the median distance of frames.
std::optional<double> container_clock(const VideoFile& file, int64_t first_ticks,
                                      int64_t median_ticks);

}  // namespace tessera
