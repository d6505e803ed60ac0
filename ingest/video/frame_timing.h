// What: how far apart a camera's frames are, and where one is missing or shown twice.
// Not: a repair: frames keep their times.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/video/rational.h"

namespace tessera {

/// Median distance of neighbours (the lower one of two) in ticks; 0 for fewer than two frames.
int64_t median_distance(const std::vector<int64_t>& ticks);

/// Lines about gaps: distances of more than 1.5 medians, the first three of them and how many there
/// are. Where they are more than a tenth of all distances the rate is variable: one line says so.
/// `ticks` increase; `camera` begins each line.
std::vector<std::string> gap_warnings(const std::string& camera, const std::vector<int64_t>& ticks,
                                      const Rational& time_base);

/// One line about the presentation times that several frames have, or none. `repeated`: each time
/// once for each frame beyond its first.
std::vector<std::string> duplicate_warnings(const std::string& camera,
                                            const std::vector<int64_t>& repeated,
                                            const Rational& time_base);

}  // namespace tessera
