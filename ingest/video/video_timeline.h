// The presentation times of the frames of a video and the defects of its clock, without decoding.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "ingest/video/clip.h"

namespace tessera {

/// Errors: InputError naming the file: no video in it, without presentation times, no frame,
/// colours that have no conversion to sRGB (frame_colour.h).
VideoTimeline read_timeline(const std::filesystem::path& path);

class VideoFile;

/// The rate that a timecode track counts at, which states a round number of counts a second: many
/// cameras count every second frame of 50 or 59.94. That of the frames where they have nothing to
/// do with each other.
Rational timecode_rate(const Rational& frames, double counts);

/// The time of a timecode HH:MM:SS:FF (drop-frame with ; before FF) counted at `rate` frames/s.
std::optional<ContainerClock> timecode_clock(const std::string& timecode, const Rational& rate);
/// Seconds since 1970 of a creation time with digits below the second that are not all 0.
std::optional<double> creation_seconds(const std::string& creation_time);

/// The time at tick 0. A timecode is that of the first frame shown, at `first_ticks`; a creation
/// time is that of tick 0. `median_ticks`: the median distance of frames.
std::optional<ContainerClock> container_clock(const VideoFile& file, int64_t first_ticks,
                                              int64_t median_ticks);

}  // namespace tessera
