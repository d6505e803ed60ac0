// Clock offsets from measurements: of two clocks from the distances of correspondences to their
// epipolar lines, of a whole rig from its pairs, and the limits below which an offset is not
// applied. Source: iterated least squares with Cauchy weights (Holland, Welsch 1977).
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

/// For each clock the offset, seconds, up to which it is left at 0; 0 for those that are not
/// determined. `frame_seconds`: of each clock's frames. An offset that is applied gives the frames
/// of that camera times of their own, so that the scene has more timesteps, which is justified only
/// where it is real and matters:
/// - it must be more than three times its standard error;
/// - and more than a tenth of a frame, in which an object moves less than while a frame is exposed;
/// - where most clocks agree to a tenth of a frame (one trigger drives the cameras), it must stand
///   out from the others: by five times their scatter, or half a frame if that is less. The
///   standard errors do not include lenses and textures that shift all frames of a pair alike.
std::vector<double> offset_limits(const std::vector<SolvedOffset>& solved,
                                  const std::vector<double>& frame_seconds);

/// A moving point that two cameras see: how far it misses its epipolar line.
struct EpipolarMiss {
  double miss = 0;     // pixels
  double slope = 0;    // pixels a second by which `miss` falls when the second clock is set later
  double seconds = 0;  // of the first clock, from the middle of what is compared
};

/// The second clock is to be set later by shift + rate · seconds.
struct PairShift {
  double shift = 0;       // seconds
  double sigma = 0;       // standard error of it, seconds
  size_t support = 0;     // moving points that agree with it
  double rate = 0;        // seconds a second: how much slower the second clock runs
  double rate_sigma = 0;  // standard error of it; infinite where the rate is undetermined
};

/// The shift within ±reach that most misses agree on, and rates of up to ±rate_reach: tried where
/// less than 3 of 5 misses agree on a constant shift, and measured in any case. Nothing where too
/// few agree.
std::optional<PairShift> shift_from_misses(const std::vector<EpipolarMiss>& misses, double reach,
                                           double frame_seconds, double rate_reach = 0);

}  // namespace tessera
