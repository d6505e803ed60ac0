// Some of many, evenly spread.
#pragma once
#include <cstdint>

namespace tessera {

/// Number i of `count` numbers that are spread evenly over 0 … total − 1, both ends among them; 0
/// where `count` is 1.
constexpr int64_t even_spread(int64_t i, int64_t count, int64_t total) {
  return count > 1 ? i * (total - 1) / (count - 1) : 0;
}

}  // namespace tessera
