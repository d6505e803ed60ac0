// What: when the frames of a video are shown, and what is wrong with its clock; nothing is decoded.
// Not: pixels (video_decoder.h).
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/clocks/rational.h"

namespace tessera {

struct VideoTimeline {
  int width = 0, height = 0;    // of the upright image: a rotation flag is undone
  Rational time_base;           // seconds a tick
  std::vector<int64_t> ticks;   // presentation times of the frames that are shown, increasing
  double frame_seconds = 0;     // median distance of two frames; 0 for one frame
  std::optional<double> clock;  // container time of tick 0, seconds since any common origin
                                // (timecode, creation time); absent where it states none
  bool has_audio = false;
  bool truncated = false;  // the file ends before what it states; `ticks` are what is there
  std::vector<std::string> warnings;  // gaps, duplicates, truncation: each with file and seconds

  double seconds(size_t frame) const { return time_base.at(ticks[frame]); }
};

/// Errors: InputError naming the file: no video in it, without presentation times, no frame.
VideoTimeline read_timeline(const std::filesystem::path& path);

}  // namespace tessera
