// What: the key by which splats are ordered front to back.
// Not: sorting (stages/bin).
// Source: sorting by the bits of a positive float [3DGS]; fewer bits are ours.
#pragma once
#include <bit>
#include <cstdint>

#include "kernels/math/scalar.h"

namespace tessera {

inline constexpr int kDepthKeyBits = 24;
inline constexpr double kDepthRange = 4294967296;  // times the near plane: 2^32, beyond: one key

/// Ascends with the depth, in world units, of at least the near plane: 32 octaves of 2^19 steps
/// behind it, so that depths within 2e-6 of each other may share a key, as may those beyond. Splats
/// of one key keep the order of Gaussians. Three passes of a radix sort instead of four.
TESSERA_HD inline uint32_t depth_key(float depth, float near_plane) {
  constexpr int kDropped = 4;  // bits of the mantissa
  constexpr uint32_t kLast = (uint32_t{1} << kDepthKeyBits) - 1;
  const uint32_t behind = std::bit_cast<uint32_t>(depth) - std::bit_cast<uint32_t>(near_plane);
  return min_of(behind >> kDropped, kLast);
}
/// The same steps in double: an order is no matter of accuracy.
TESSERA_HD inline uint32_t depth_key(double depth, double near_plane) {
  return depth_key(float(depth), float(near_plane));
}

}  // namespace tessera
