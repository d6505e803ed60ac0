// The stable order of unsigned keys by a serial radix sort, least significant digit first. 200,000
// keys take about a millisecond, a hundredth of a step.
#pragma once
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/base/buffer.h"

namespace tessera {

/// order[i] = index of the i-th smallest of key(0) … key(count − 1); equal keys keep their order.
template <class KeyOf>
void radix_order(KeyOf&& key, int64_t count, Buffer<int32_t>& order) {
  using Key = decltype(key(int64_t{0}));
  constexpr int kDigitBits = 12, kDigits = 1 << kDigitBits;
  order.resize(count);
  std::iota(order.begin(), order.end(), 0);
  Buffer<int32_t> other(count);
  for (int shift = 0; shift < int(8 * sizeof(Key)); shift += kDigitBits) {
    const auto digit = [&, shift](int64_t i) { return size_t(key(i) >> shift & (kDigits - 1)); };
    std::array<int64_t, kDigits + 1> place{};
    for (int64_t i = 0; i < count; ++i) ++place[digit(i) + 1];
    if (count > 0 && place[digit(0) + 1] == count) continue;  // one digit only
    for (size_t d = 1; d < place.size(); ++d) place[d] += place[d - 1];
    for (int64_t i = 0; i < count; ++i) {
      const int32_t index = order[i];
      other[place[digit(index)]++] = index;
    }
    std::swap(order, other);
  }
}

}  // namespace tessera
