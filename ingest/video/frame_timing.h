// Timestamps as ticks of a rational time base, the median distance of frames, and warnings about
// gaps and duplicates. Frames keep their times.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

struct Rational {
  int64_t numerator = 1, denominator = 1;
  /// `ticks` of this clock in its unit (seconds for video clocks).
  double at(int64_t ticks) const { return double(ticks) * double(numerator) / double(denominator); }
};

/// Median distance of neighbours (the lower one of two) in ticks; 0 for fewer than two frames.
int64_t median_distance(const std::vector<int64_t>& ticks);

/// Lines about gaps: distances of more than 1.5 medians, the first three of them and how many there
/// are. Where they are more than a tenth of all distances the rate is variable, which is one line.
/// `ticks` increase; `camera` begins each line.
std::vector<std::string> gap_warnings(const std::string& camera, const std::vector<int64_t>& ticks,
                                      const Rational& time_base);

/// One line about the presentation times that several frames have, or none. `repeated`: each time
/// once for each frame beyond its first.
std::vector<std::string> duplicate_warnings(const std::string& camera,
                                            const std::vector<int64_t>& repeated,
                                            const Rational& time_base);

}  // namespace tessera
