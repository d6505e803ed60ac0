// The memory of the host: allocation that is aligned for vector loads, and the peak of the process.
#include "kernels/base/buffer.h"

#include <sys/resource.h>

namespace tessera {
namespace {

constexpr std::align_val_t kAlignment{64};  // bytes: one AVX-512 vector, one cache line

class HostMemory final : public Memory {
 public:
  void* allocate(size_t bytes) override { return ::operator new(bytes, kAlignment); }
  void release(void* pointer, size_t) noexcept override { ::operator delete(pointer, kAlignment); }
  void copy(void* to, const void* from, size_t bytes) override { std::memcpy(to, from, bytes); }
  /// Of the whole program: the host's memory has no other owner.
  int64_t peak_bytes() const override {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return int64_t(usage.ru_maxrss) * 1024;
  }
};

}  // namespace

Memory& host_memory() {
  static HostMemory memory;
  return memory;
}

}  // namespace tessera
