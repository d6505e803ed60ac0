// Conversion of CUDA's return codes to the reason why a device cannot be used.
#include "kernels/device_probe.h"

#include <cuda_runtime.h>

namespace tessera {
namespace {

/// Compiled for the same cards as all others.
__global__ void probe() {}

CudaFailure failure_of(cudaError_t code, int driver_version) {
  switch (code) {
    case cudaSuccess:
      return CudaFailure::kNone;
    case cudaErrorInsufficientDriver:  // also where there is no driver
    case cudaErrorUnsupportedPtxVersion:
      return driver_version == 0 ? CudaFailure::kNoDriver : CudaFailure::kOldDriver;
    case cudaErrorNoDevice:
      return CudaFailure::kNoDevice;
    case cudaErrorNoKernelImageForDevice:
    case cudaErrorInvalidDeviceFunction:
      return CudaFailure::kNoKernels;
    case cudaErrorMemoryAllocation:
      return CudaFailure::kNoMemory;
    default:
      return CudaFailure::kOther;
  }
}

void record(cudaError_t code, CudaProbe& result) {
  cudaGetLastError();  // clears what is not sticky
  result.failure = failure_of(code, result.driver_version);
  result.error = code == cudaSuccess ? "" : cudaGetErrorString(code);
}

cudaError_t list_devices(int count, std::vector<CudaDevice>& devices) {
  for (int i = 0; i < count; ++i) {
    cudaDeviceProp properties{};
    const cudaError_t code = cudaGetDeviceProperties(&properties, i);
    if (code != cudaSuccess) return code;
    devices.push_back({properties.name, 10 * properties.major + properties.minor});
  }
  return cudaSuccess;
}

/// Makes the context, and finds the kernel's code for this card.
cudaError_t try_device(int device) {
  const cudaError_t code = cudaSetDevice(device);
  if (code != cudaSuccess) return code;
  cudaFuncAttributes attributes{};
  return cudaFuncGetAttributes(&attributes, probe);
}

}  // namespace

CudaProbe probe_cuda(int device) {
  CudaProbe result;
  for (const int architecture : {__CUDA_ARCH_LIST__})
    result.architectures.push_back(architecture / 10);
  result.tried = device;
  cudaRuntimeGetVersion(&result.runtime_version);
  cudaDriverGetVersion(&result.driver_version);
  int count = 0;
  record(cudaGetDeviceCount(&count), result);
  if (result.failure == CudaFailure::kNone && count == 0) result.failure = CudaFailure::kNoDevice;
  if (result.failure != CudaFailure::kNone) return result;
  record(list_devices(count, result.devices), result);
  if (result.failure == CudaFailure::kNone && device < count) record(try_device(device), result);
  return result;
}

}  // namespace tessera
