// Counter-based random numbers without state: equal (seed, stream, index) give equal numbers on any
// backend, in any order and on any number of threads. Source: Philox4x32-10 [Salmon11]; normals by
// Box–Muller.
#pragma once
#include <cstdint>

#include "kernels/math/symmetric.h"

namespace tessera {

/// What the numbers are for: keeps unrelated draws with equal indices apart.
enum class RandomStream : uint32_t {
  kInitialise = 1,
  kSampler = 2,
  kSplit = 3,
  kRelocation = 4,
  kPositionNoise = 5,
  kGrowth = 6,
  kSpawn = 7,
  kValidationSplit = 9
};

struct RandomBlock {
  uint32_t word[4];
};

TESSERA_HD inline RandomBlock philox(uint64_t seed, RandomStream stream, uint64_t index,
                                     uint32_t round_of_index = 0) {
  uint32_t c0 = uint32_t(index), c1 = uint32_t(index >> 32), c2 = uint32_t(stream),
           c3 = round_of_index;
  uint32_t k0 = uint32_t(seed), k1 = uint32_t(seed >> 32);
  for (int round = 0; round < 10; ++round) {
    const uint64_t p0 = uint64_t(0xD2511F53u) * c0, p1 = uint64_t(0xCD9E8D57u) * c2;
    c0 = uint32_t(p1 >> 32) ^ c1 ^ k0;
    c1 = uint32_t(p1);
    c2 = uint32_t(p0 >> 32) ^ c3 ^ k1;
    c3 = uint32_t(p0);
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  return {{c0, c1, c2, c3}};
}

/// In [0, 1), 24 bits, exact in float.
TESSERA_HD inline float uniform(uint32_t word) {
  return float(word >> 8) * (1.0f / 16777216.0f);
}

/// In 0 … count − 1, from 64 bits: the high half of their product with `count`.
TESSERA_HD inline uint64_t uniform_below(const RandomBlock& block, uint64_t count) {
  const uint64_t high = uint64_t(block.word[0]) * (count >> 32);
  const uint64_t low = uint64_t(block.word[1]) * (count & 0xFFFFFFFFu);
  const uint64_t cross = uint64_t(block.word[0]) * (count & 0xFFFFFFFFu);
  const uint64_t across = uint64_t(block.word[1]) * (count >> 32);
  const uint64_t middle = (low >> 32) + (cross & 0xFFFFFFFFu) + (across & 0xFFFFFFFFu);
  return high + (cross >> 32) + (across >> 32) + (middle >> 32);
}

/// Four independent standard normals.
TESSERA_HD inline Vec4<float> normals(const RandomBlock& block) {
  Vec4<float> result;
  for (int pair = 0; pair < 2; ++pair) {
    const float u = 1.0f - uniform(block.word[2 * pair]);  // (0, 1]
    const float angle = 6.2831853f * uniform(block.word[2 * pair + 1]);
    const float radius = sqrt(-2.0f * log(u));
    result[2 * pair] = radius * std::cos(angle);
    result[2 * pair + 1] = radius * std::sin(angle);
  }
  return result;
}

}  // namespace tessera
