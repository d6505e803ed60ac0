// What: the text of a DeviceError.
// Not: anything that runs on the device.
#include "kernels/cuda/device_error.h"

#include "kernels/base/errors.h"

namespace tessera {

void check_device(cudaError_t code, const char* what) {
  if (code == cudaSuccess) return;
  cudaGetLastError();  // clears what is not sticky
  size_t free_bytes = 0, all_bytes = 0;
  std::string memory;
  if (cudaMemGetInfo(&free_bytes, &all_bytes) == cudaSuccess)
    memory = "; " + std::to_string(free_bytes >> 20) + " of " + std::to_string(all_bytes >> 20) +
             " MiB of device memory are free";
  const bool foreign = code == cudaErrorNoKernelImageForDevice;
  const char* remedy =
      foreign ? "; configure with -DCMAKE_CUDA_ARCHITECTURES=native on the machine of this card"
              : "";
  throw DeviceError(std::string(what) + ": " + cudaGetErrorString(code) + memory + remedy);
}

unsigned grid_of(int64_t count, int threads) {
  const int64_t blocks = (count + threads - 1) / threads;
  if (blocks > INT32_MAX)
    throw DeviceError("a kernel over " + std::to_string(count) +
                      " items does not fit a launch; use a smaller batch or fewer Gaussians");
  return unsigned(blocks > 0 ? blocks : 1);
}

}  // namespace tessera
