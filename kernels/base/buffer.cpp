// What: the host's Memory: aligned allocation for vector loads.
// Not: an arena; Buffers keep their capacity, which makes one unnecessary on the host.
#include "kernels/base/buffer.h"

namespace tessera {
namespace {

constexpr std::align_val_t kAlignment{64};  // bytes: one AVX-512 vector, one cache line

class HostMemory final : public Memory {
 public:
  void* allocate(size_t bytes) override { return ::operator new(bytes, kAlignment); }
  void release(void* pointer, size_t) noexcept override { ::operator delete(pointer, kAlignment); }
  void copy(void* to, const void* from, size_t bytes) override { std::memcpy(to, from, bytes); }
};

}  // namespace

Memory& host_memory() {
  static HostMemory memory;
  return memory;
}

}  // namespace tessera
