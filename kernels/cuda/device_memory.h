// Device memory from the driver's stream-ordered pool, with a limit, a peak and copies, and
// Scratch, which divides one buffer into the arrays of a stage. The pool reserves virtual addresses
// and maps pages behind them, so a set that grows and shrinks does not fragment it.
#pragma once
#include <cuda_runtime.h>

#include "kernels/base/buffer.h"
#include "kernels/base/errors.h"

namespace tessera {

class DeviceMemory final : public Memory {
 public:
  /// Allocations and frees are ordered on `stream`.
  explicit DeviceMemory(cudaStream_t stream);
  DeviceMemory(const DeviceMemory&) = delete;
  ~DeviceMemory() override;

  /// Errors: DeviceError with need, have and advice.
  void* allocate(size_t bytes) override;
  void release(void* pointer, size_t bytes) noexcept override;
  /// Any direction; returns when the bytes are there.
  void copy(void* to, const void* from, size_t bytes) override;
  /// From host memory, on a stream of its own; `wait_copies` makes later kernels wait for it.
  void copy_async_in(void* to, const void* from, size_t bytes) override;
  void wait_copies() override;
  void pin(const void* host, size_t bytes) override;
  void unpin(const void* host) override;
  /// At first what is asked for, then a little more: pages are cheap to exchange.
  int64_t grown(int64_t count, int64_t capacity) const override {
    return capacity == 0 ? count : count + count / 16;
  }
  void trim() override;
  int64_t free_bytes() const override;
  /// The most that the pool has held.
  int64_t peak_bytes() const override;
  /// Allocations beyond fail as if the card were that small; 0: none. For forecasts and tests.
  void set_limit(int64_t bytes) override { limit_ = bytes; }

 private:
  cudaStream_t stream_, copies_ = nullptr;
  cudaEvent_t copied_ = nullptr, computed_ = nullptr;
  cudaMemPool_t pool_ = nullptr;
  int64_t in_use_ = 0, limit_ = 0;
};

/// First `plan` every array, then `allocate`, then `take` them in the same order.
class Scratch {
 public:
  explicit Scratch(Buffer<uint8_t>& buffer) : buffer_(buffer) {}

  template <class T>
  void plan(int64_t count) {
    wanted_ += aligned(int64_t(sizeof(T)) * count);
  }
  void allocate() { buffer_.resize(wanted_); }
  template <class T>
  Span<T> take(int64_t count) {
    T* data = reinterpret_cast<T*>(buffer_.data() + taken_);
    taken_ += aligned(int64_t(sizeof(T)) * count);
    check(taken_ <= wanted_, "scratch: more taken than planned");
    return {data, count};
  }

 private:
  static int64_t aligned(int64_t bytes) { return (bytes + 255) / 256 * 256; }

  Buffer<uint8_t>& buffer_;
  int64_t wanted_ = 0, taken_ = 0;
};

}  // namespace tessera
