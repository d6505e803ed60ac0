// What: Span<T>, the only form of memory a kernel sees: a pointer and a length, trivially copyable.
// Not: an owner (buffer.h), and no bounds checks in release builds.
#pragma once
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "kernels/base/host_device.h"

namespace tessera {

template <class T>
struct Span {
  T* data = nullptr;
  int64_t size = 0;

  Span() = default;
  TESSERA_HD Span(T* pointer, int64_t count) : data(pointer), size(count) {}
  /// A span of mutable values is also a span of constant ones.
  template <class U, class = std::enable_if_t<std::is_same_v<const U, T>>>
  TESSERA_HD Span(const Span<U>& other) : data(other.data), size(other.size) {}

  TESSERA_HD T& operator[](int64_t index) const {
#if !defined(__CUDA_ARCH__)
    assert(index >= 0 && index < size);
#endif
    return data[index];
  }
  TESSERA_HD T* begin() const {
    return data;
  }
  TESSERA_HD T* end() const {
    return data + size;
  }
  TESSERA_HD bool empty() const {
    return size == 0;
  }
};

}  // namespace tessera
