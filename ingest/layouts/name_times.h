// Numbers in the names of images that are times: stamps of ROS, Kinect, RealSense or phones.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "ingest/layouts/image_sequences.h"
#include "ingest/video/frame_timing.h"

namespace tessera {

/// Seconds a number where the numbers of all sequences are times, else nothing. They are where they
/// are seconds, ms, µs or ns since 1970 (of the years 2001 to 2096), and where the median distance
/// of two is 1 to 500 frames a second in µs or ns, or in ms with distances that vary: numbers of
/// frames lie less far apart, and equally far.
std::optional<Rational> seconds_of_names(const std::vector<ImageSequence>& sequences);

/// Where the numbers are times: says so in `found`, and counts them from the first of all.
void take_times(ImageSequences& found);

/// The median distance of neighbours over all sequences; 0 where there are none.
int64_t median_step(const std::vector<ImageSequence>& sequences);

}  // namespace tessera
