// The stream-ordered pool of DeviceMemory, its limit and its copies.
#include "kernels/cuda/device_memory.h"

#include "kernels/base/errors.h"
#include "kernels/cuda/launch.cuh"

namespace tessera {

DeviceMemory::DeviceMemory(cudaStream_t stream) : stream_(stream) {
  int device = 0;
  check_device(cudaGetDevice(&device), "cudaGetDevice");
  cudaMemPoolProps properties{};
  properties.allocType = cudaMemAllocationTypePinned;
  properties.location = {cudaMemLocationTypeDevice, device};
  check_device(cudaMemPoolCreate(&pool_, &properties), "cudaMemPoolCreate");
  uint64_t keep = UINT64_MAX;  // freed pages stay with the pool
  check_device(cudaMemPoolSetAttribute(pool_, cudaMemPoolAttrReleaseThreshold, &keep),
               "cudaMemPoolSetAttribute");
  check_device(cudaStreamCreateWithFlags(&copies_, cudaStreamNonBlocking), "cudaStreamCreate");
  check_device(cudaEventCreateWithFlags(&copied_, cudaEventDisableTiming), "cudaEventCreate");
  check_device(cudaEventCreateWithFlags(&computed_, cudaEventDisableTiming), "cudaEventCreate");
}

DeviceMemory::~DeviceMemory() {
  cudaStreamSynchronize(stream_);
  cudaStreamDestroy(copies_);
  cudaEventDestroy(copied_);
  cudaEventDestroy(computed_);
  cudaMemPoolDestroy(pool_);
}

namespace {

/// Large blocks in classes 1/32 of a power of two apart, so that the old copy of one group is the
/// right size for the new copy of the next.
size_t size_class(size_t bytes) {
  constexpr size_t kSmall = size_t{1} << 20;
  if (bytes < kSmall) return bytes > 0 ? bytes : 1;
  size_t step = kSmall / 32;
  while (step * 64 <= bytes) step *= 2;
  return (bytes + step - 1) / step * step;
}

}  // namespace

void* DeviceMemory::allocate(size_t bytes) {
  const size_t wanted = size_class(bytes);
  void* pointer = nullptr;
  const bool within = limit_ == 0 || in_use_ + int64_t(wanted) <= limit_;
  const cudaError_t code = within ? cudaMallocFromPoolAsync(&pointer, wanted, pool_, stream_)
                                  : cudaErrorMemoryAllocation;
  if (code == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    throw DeviceError("out of device memory: need " + std::to_string(wanted >> 20) + " MiB more, " +
                      std::to_string(in_use_ >> 20) + " MiB are in use and " +
                      std::to_string(free_bytes() >> 20) +
                      " MiB free; use a smaller batch, smaller images or --max-gaussians");
  }
  check_device(code, "cudaMallocFromPoolAsync");
  in_use_ += int64_t(wanted);
  return pointer;
}

void DeviceMemory::release(void* pointer, size_t bytes) noexcept {
  cudaFreeAsync(pointer, stream_);
  in_use_ -= int64_t(size_class(bytes));
}

void DeviceMemory::copy(void* to, const void* from, size_t bytes) {
  if (bytes == 0) return;
  check_device(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDefault, stream_), "cudaMemcpyAsync");
  check_device(cudaStreamSynchronize(stream_), "waiting for a copy and the kernels before it");
}

void DeviceMemory::copy_async_in(void* to, const void* from, size_t bytes) {
  // the target may still be read by kernels that were enqueued before
  check_device(cudaEventRecord(computed_, stream_), "cudaEventRecord");
  check_device(cudaStreamWaitEvent(copies_, computed_, 0), "cudaStreamWaitEvent");
  check_device(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, copies_),
               "cudaMemcpyAsync");
  check_device(cudaEventRecord(copied_, copies_), "cudaEventRecord");
}

void DeviceMemory::pin(const void* host, size_t bytes) {
  // where the system refuses, copies go through the driver's own pinned buffer
  if (cudaHostRegister(const_cast<void*>(host), bytes, cudaHostRegisterDefault) != cudaSuccess)
    cudaGetLastError();
}

void DeviceMemory::unpin(const void* host) {
  cudaStreamSynchronize(copies_);
  if (cudaHostUnregister(const_cast<void*>(host)) != cudaSuccess) cudaGetLastError();
}

void DeviceMemory::wait_copies() {
  check_device(cudaStreamWaitEvent(stream_, copied_, 0), "cudaStreamWaitEvent");
}

void DeviceMemory::trim() {
  check_device(cudaStreamSynchronize(stream_), "waiting to trim memory");
  check_device(cudaMemPoolTrimTo(pool_, 0), "cudaMemPoolTrimTo");
}

int64_t DeviceMemory::free_bytes() const {
  size_t free_bytes = 0, all_bytes = 0;
  uint64_t reserved = 0, used = 0;
  cudaMemGetInfo(&free_bytes, &all_bytes);
  cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrReservedMemCurrent, &reserved);
  cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrUsedMemCurrent, &used);
  const int64_t available = int64_t(free_bytes) + int64_t(reserved) - int64_t(used);
  return limit_ == 0 ? available : std::min(available, limit_ - in_use_);
}

int64_t DeviceMemory::peak_bytes() const {
  uint64_t peak = 0;
  cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrReservedMemHigh, &peak);
  return int64_t(peak);
}

}  // namespace tessera
