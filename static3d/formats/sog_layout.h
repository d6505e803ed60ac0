// What the reader and the writer of .sog share: names of files, the logarithmic scale of means and
// the packing of quaternions. Source: formats 1.6 (PlayCanvas, "The SOG Format", version 2).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "static3d/transform/splat_quanta.h"

namespace tessera {

inline constexpr const char* kSogMeta = "meta.json";
inline constexpr int kSogVersion = 2;
inline constexpr int kSogEntriesPerRow = 64;       // of the palette in its image
inline constexpr int64_t kSogMostEntries = 65536;  // labels have 16 bits
inline constexpr int kSogLargest = 252;            // of the alpha channel of quaternions
inline constexpr int kSogSteps = 65535;            // of a mean in its range

inline double sog_logarithm(double x) {
  return std::copysign(std::log1p(std::abs(x)), x);
}
inline double sog_exponential(double x) {
  return std::copysign(std::expm1(std::abs(x)), x);
}

/// Of a unit quaternion w, x, y, z: three parts over ±√½, and the index of the largest part.
inline std::array<uint8_t, 4> sog_quaternion(const float* wxyz) {
  const std::array<double, 4> q = {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
  const int largest = largest_of(q);
  const double sign = q[size_t(largest)] < 0 ? -1 : 1;
  std::array<uint8_t, 4> bytes{};
  size_t place = 0;
  for (int k = 0; k < 4; ++k)
    if (k != largest) bytes[place++] = byte_of(255 * (sign * q[size_t(k)] * std::sqrt(0.5) + 0.5));
  bytes[3] = uint8_t(kSogLargest + largest);
  return bytes;
}

/// The fourth byte is at least kSogLargest.
inline void sog_quaternion_of(const std::array<uint8_t, 4>& bytes, float* wxyz) {
  const int largest = bytes[3] - kSogLargest;
  std::array<double, 4> q{};
  size_t place = 0;
  for (int k = 0; k < 4; ++k)
    if (k != largest) q[size_t(k)] = (bytes[place++] / 255.0 - 0.5) * std::sqrt(2.0);
  q[size_t(largest)] = left_out(q, largest);
  for (size_t k = 0; k < 4; ++k) wxyz[k] = float(q[k]);
}

}  // namespace tessera
