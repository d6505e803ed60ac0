// Keys of sorts: the depth key of a splat, and the Morton code and time bin by which neighbours in
// space and time become neighbours in memory. Source: sorting by the bits of a positive float
// [3DGS], here with fewer bits; method A.14, D.7.
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

inline constexpr int kMortonBits = 21;  // an axis
inline constexpr int kTimeBins = 32;

/// The box of the means of a set; [3] is time.
struct LocalityBox {
  float low[4], high[4];
};

/// Bit i of the low 21 bits moves to bit 3·i.
TESSERA_HD inline uint64_t spread_bits(uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffffull;
  x = (x | x << 16) & 0x1f0000ff0000ffull;
  x = (x | x << 8) & 0x100f00f00f00f00full;
  x = (x | x << 4) & 0x10c30c30c30c30c3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}

/// x lowest; cells are cubes, 2^21 along the longest side of the box.
TESSERA_HD inline uint64_t morton_code(const LocalityBox& box, float x, float y, float z) {
  const float side =
      max_of(max_of(box.high[0] - box.low[0], box.high[1] - box.low[1]), box.high[2] - box.low[2]);
  const auto cell = [side](float value, float low) {
    const float unit = side > 0 ? clamp_to((value - low) / side, 0.0f, 1.0f) : 0.0f;
    return uint64_t(double(unit) * double((1 << kMortonBits) - 1));
  };
  return spread_bits(cell(x, box.low[0])) | spread_bits(cell(y, box.low[1])) << 1 |
         spread_bits(cell(z, box.low[2])) << 2;
}

TESSERA_HD inline uint32_t time_bin(const LocalityBox& box, float time) {
  const float range = box.high[3] - box.low[3];
  if (!(range > 0)) return 0;
  const float bin = float(kTimeBins) * (time - box.low[3]) / range;
  return uint32_t(clamp_to(bin, 0.0f, float(kTimeBins - 1)));
}

}  // namespace tessera
