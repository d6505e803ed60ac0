// What: asks for the cache lines of an element some loop rounds before it is needed.
// Not: needed for any result; for loops on the host that visit elements in an order of indices,
//      where the processor sees the next address too late.
#pragma once
#include <cstdint>

namespace tessera {

/// values[index[i + Ahead]], when that is before `end`.
template <int Ahead, class Values, class Index>
inline void prefetch(const Values& values, const Index& index, int64_t i, int64_t end) {
  if (i + Ahead >= end) return;
  const auto* const element = &values[index[i + Ahead]];
  __builtin_prefetch(element);
  __builtin_prefetch(reinterpret_cast<const char*>(element + 1) - 1);  // may lie in two lines
}

}  // namespace tessera
