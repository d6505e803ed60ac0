// Seeded integer hashing to uniform and normal numbers, the only source of randomness here. It has
// no state, so results depend neither on order nor on the number of threads. Source: mixing
// constants of C. Wellons' "lowbias32".
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

namespace tessera::synth {

inline uint32_t mix(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

/// A hash of up to three integers under a seed.
inline uint32_t hash(uint32_t seed, int64_t a, int64_t b = 0, int64_t c = 0) {
  uint32_t h = mix(seed ^ 0x9e3779b9u);
  h = mix(h + 0x85ebca6bu * uint32_t(a));
  h = mix(h + 0xc2b2ae35u * uint32_t(b));
  return mix(h + 0x27d4eb2fu * uint32_t(c));
}

/// Uniform in [0, 1).
inline double unit(uint32_t h) {
  return (h >> 8) * 0x1p-24;
}
/// Uniform in [-1, 1).
inline double signed_unit(uint32_t h) {
  return 2 * unit(h) - 1;
}

/// Standard normal from one hash (Box–Muller on two of its descendants).
inline double normal(uint32_t h) {
  const double u = 1 - unit(mix(h)), v = unit(mix(h + 0x68bc21ebu));
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

}  // namespace tessera::synth
