// Quantised values that splat formats share: opacities, and quaternions by their three smallest
// components.
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

/// Nearest of the numbers of `bits` bits to a value of 0 to 1 of their range.
inline uint32_t bits_of(double unit, int bits) {
  const double most = double((1u << bits) - 1);
  return uint32_t(std::clamp(std::floor(unit * most + 0.5), 0.0, most));
}

/// `bits` bits of `word` from bit `low` up, as a fraction of their range.
inline double fraction_of(uint32_t word, int low, int bits) {
  const uint32_t mask = (1u << bits) - 1;
  return double(word >> low & mask) / mask;
}

/// A unit quaternion w,x,y,z in a word: the index of its largest part on top, which is made
/// positive, the three others in 10 bits each over ±√½.
inline uint32_t smallest_three(const float* wxyz) {
  const std::array<double, 4> q = {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
  const int largest = largest_of(q);
  const double sign = q[size_t(largest)] < 0 ? -1 : 1;
  auto word = uint32_t(largest);
  for (int k = 0; k < 4; ++k)
    if (k != largest) word = word << 10 | bits_of(sign * q[size_t(k)] * std::sqrt(0.5) + 0.5, 10);
  return word;
}

inline void quaternion_of(uint32_t word, float* wxyz) {
  const int largest = int(word >> 30);
  std::array<double, 4> q{};
  int low = 20;
  for (int k = 0; k < 4; ++k) {
    if (k == largest) continue;
    q[size_t(k)] = (fraction_of(word, low, 10) - 0.5) * std::sqrt(2.0);
    low -= 10;
  }
  q[size_t(largest)] = left_out(q, largest);
  for (size_t k = 0; k < 4; ++k) wxyz[k] = float(q[k]);
}

}  // namespace tessera
