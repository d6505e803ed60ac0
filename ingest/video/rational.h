// What: a ratio of two integers, as containers state their clocks.
// Not: arithmetic; timestamps become doubles once, at the end.
#pragma once
#include <cstdint>

namespace tessera {

struct Rational {
  int64_t numerator = 1, denominator = 1;
  /// `ticks` of this clock in its unit (seconds for video clocks).
  double at(int64_t ticks) const { return double(ticks) * double(numerator) / double(denominator); }
};

}  // namespace tessera
