// What: several arrays of one stage out of one buffer that only grows.
// Not: memory that outlives the stage.
#pragma once
#include "kernels/base/buffer.h"
#include "kernels/base/errors.h"

namespace tessera {

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
