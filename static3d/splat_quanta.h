// What: the bytes that splat formats share: opacities, quaternions by their three smallest parts.
// Not: one format's own scales and orders.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "kernels/math/splat.h"

namespace tessera {

/// Nearest of 0 … 255.
inline uint8_t byte_of(double value) {
  return uint8_t(std::clamp(std::floor(value + 0.5), 0.0, 255.0));
}

inline uint8_t opacity_byte(float logit) {
  return byte_of(255 * sigmoid(double(logit)));
}

/// Opacity 0 and 255 stand for what rounds there: a quarter of a step from the end.
inline float logit_of_byte(double byte) {
  constexpr double kEnd = 0.25 / 255;
  const double opacity = std::clamp(byte / 255, kEnd, 1 - kEnd);
  return float(std::log(opacity / (1 - opacity)));
}

/// Of four numbers the index of the one of largest magnitude; of equals the first.
inline int largest_of(const std::array<double, 4>& q) {
  int largest = 0;
  for (int k = 1; k < 4; ++k)
    if (std::abs(q[size_t(k)]) > std::abs(q[size_t(largest)])) largest = k;
  return largest;
}

/// The part that is left out of a unit quaternion, from the three others.
inline double left_out(const std::array<double, 4>& q, int largest) {
  double rest = 1;
  for (int k = 0; k < 4; ++k)
    if (k != largest) rest -= q[size_t(k)] * q[size_t(k)];
  return std::sqrt(std::max(rest, 0.0));
}

}  // namespace tessera
