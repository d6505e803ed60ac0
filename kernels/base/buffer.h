// Span<T>, a trivially copyable pointer with a length and the only form of memory that a kernel
// takes; Memory, which allocates bytes on the host or on a device; and Buffer<T>, a move-only
// 64-byte aligned array in a Memory. A Buffer keeps its capacity; `resize` does not keep values,
// `grow_keep` does.
#pragma once
#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <type_traits>
#include <utility>

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

/// Where a Buffer's bytes live. A backend owns one; the host's is `host_memory()`.
class Memory {
 public:
  virtual ~Memory() = default;
  /// 64-byte aligned bytes, never null. Errors: std::bad_alloc (host), DeviceError (device).
  virtual void* allocate(size_t bytes) = 0;
  virtual void release(void* pointer, size_t bytes) noexcept = 0;
  /// Any direction between this memory and the host's; returns when the bytes are there.
  virtual void copy(void* to, const void* from, size_t bytes) = 0;
  /// From the host's memory, perhaps later; `wait_copies` orders what is enqueued next after it.
  virtual void copy_async_in(void* to, const void* from, size_t bytes) { copy(to, from, bytes); }
  virtual void wait_copies() {}
  /// Host memory that `copy_async_in` will read again and again; a hint.
  virtual void pin(const void*, size_t) {}
  virtual void unpin(const void*) {}
  /// Elements to make room for when a buffer of `capacity` has to hold `count`.
  virtual int64_t grown(int64_t count, int64_t capacity) const {
    return std::max(count, capacity + capacity / 2);
  }
  /// Bytes that could still be allocated.
  virtual int64_t free_bytes() const { return INT64_MAX; }
  /// Gives pages that nothing uses back to the system; waits for a device.
  virtual void trim() {}
  /// The most that was in use so far.
  virtual int64_t peak_bytes() const { return 0; }
  /// Allocations beyond fail; 0: no limit.
  virtual void set_limit(int64_t) {}
};

/// Memory of the host, shared by every CPU buffer.
Memory& host_memory();

template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() : memory_(&host_memory()) {}
  explicit Buffer(Memory& memory) : memory_(&memory) {}
  explicit Buffer(int64_t count, Memory& memory = host_memory()) : memory_(&memory) {
    resize(count);
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  Buffer(Buffer&& other) noexcept
      : memory_(other.memory_),
        data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  Buffer& operator=(Buffer&& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  ~Buffer() {
    if (data_ != nullptr) memory_->release(data_, sizeof(T) * static_cast<size_t>(capacity_));
  }

  /// Sets the length; contents are undefined afterwards where memory had to grow. Errors: as
  /// Memory::allocate; the buffer then is empty.
  void resize(int64_t count) {
    reserve(count, 0);
    size_ = count;
  }
  /// Gives the memory back; the length becomes 0.
  void release() { *this = Buffer(*memory_); }
  /// Sets the length and keeps the values that fit.
  void grow_keep(int64_t count) {
    reserve(count, std::min(size_, count));
    size_ = count;
  }

  /// Becomes a copy of a buffer in the same or in another memory.
  void copy_from(const Buffer& from) {
    resize(from.size_);
    if (size_ == 0) return;
    Memory& mover = memory_ == &host_memory() ? *from.memory_ : *memory_;
    mover.copy(data_, from.data_, sizeof(T) * static_cast<size_t>(size_));
  }

  Buffer clone_to(Memory& memory) const {
    Buffer copy(memory);
    copy.copy_from(*this);
    return copy;
  }

  Memory& memory() const { return *memory_; }
  int64_t size() const { return size_; }
  int64_t capacity() const { return capacity_; }
  bool empty() const { return size_ == 0; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](int64_t index) { return span()[index]; }
  const T& operator[](int64_t index) const { return span()[index]; }
  Span<T> span() { return {data_, size_}; }
  Span<const T> span() const { return {data_, size_}; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }

 private:
  void reserve(int64_t count, int64_t keep) {
    if (count <= capacity_) return;
    const int64_t wanted = memory_->grown(count, capacity_);
    if (keep == 0) release();  // never both at once; a buffer that finds no memory is empty
    T* grown = static_cast<T*>(memory_->allocate(sizeof(T) * static_cast<size_t>(wanted)));
    if (keep > 0) memory_->copy(grown, data_, sizeof(T) * static_cast<size_t>(keep));
    if (data_ != nullptr) memory_->release(data_, sizeof(T) * static_cast<size_t>(capacity_));
    data_ = grown;
    capacity_ = wanted;
  }

  Memory* memory_;
  T* data_ = nullptr;
  int64_t size_ = 0;
  int64_t capacity_ = 0;
};

constexpr double kMiB = 1 << 20;

}  // namespace tessera
