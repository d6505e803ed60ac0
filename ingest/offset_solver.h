// What: clock offsets from measurements: of two clocks from how far each correspondence misses its
//       epipolar line, of a whole rig from its pairs.
// Not: where the measurements come from (media/sync_motion.h, media/sync_audio.h).
// Source: least squares with Cauchy weights (Holland, Welsch 1977), iterated.
#pragma once
#include <optional>
#include <vector>

namespace tessera {

/// Clock b is to be set later by `offset` seconds than clock a.
struct PairOffset {
  int a = 0, b = 0;
  double offset = 0;  // seconds: offset of b − offset of a
  double sigma = 0;   // standard error of it, seconds
};

struct SolvedOffset {
  double offset = 0;        // seconds
  double sigma = 0;         // standard error of it, seconds
  bool determined = false;  // by pairs that connect it with the largest group of clocks
};

/// Offsets of `count` clocks that fit the pairs best; a pair that contradicts the others counts
/// little. Gauge: the median of the determined offsets is 0; the others are 0.
std::vector<SolvedOffset> solve_offsets(int count, const std::vector<PairOffset>& pairs);

/// The offset in the middle by size; of an even count the lower one, so that one clock stays.
double median_offset(std::vector<double> offsets);

/// A moving point that two cameras see: how far it misses its epipolar line.
struct EpipolarMiss {
  double miss = 0;   // pixels
  double slope = 0;  // pixels a second by which `miss` falls when the second clock is set later
};

struct PairShift {
  double shift = 0;    // seconds the second clock is to be set later
  double sigma = 0;    // standard error of it, seconds
  size_t support = 0;  // moving points that agree with it
};

/// The shift within ±reach that most misses agree on; nothing where too few do.
std::optional<PairShift> shift_from_misses(const std::vector<EpipolarMiss>& misses, double reach,
                                           double frame_seconds);

}  // namespace tessera
