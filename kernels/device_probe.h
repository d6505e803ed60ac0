// The state of CUDA in this build and on this machine, and whether a device can be used. Nothing
// stays allocated but the context of the device.
#pragma once
#include <string>
#include <vector>

namespace tessera {

struct CudaDevice {
  std::string name;      // "NVIDIA H200"
  int architecture = 0;  // 90: sm_90
};

/// What stands between the program and a device, the first that does.
enum class CudaFailure {
  kNone,
  kNotBuilt,   // the program has no CUDA backend
  kNoDriver,   // no driver library was found
  kOldDriver,  // it is older than the CUDA of this build
  kNoDevice,   // the driver shows none
  kNoKernels,  // the program has none for this card
  kNoMemory,   // not even for the device's context
  kOther,
};

struct CudaProbe {
  CudaFailure failure = CudaFailure::kNotBuilt;
  std::string error;                            // CUDA's own words, where there are any
  int runtime_version = 0, driver_version = 0;  // 13000: CUDA 13.0; 0: none
  std::vector<int> architectures;               // with kernels in this build; 90: sm_90
  std::vector<CudaDevice> devices;              // that the driver shows
  int tried = 0;                                // whose failure this is
};

/// Counts the devices and tries the one of that number, which makes its context and loads a kernel
/// on it. Throws nothing of CUDA's. With another number than there are devices nothing is tried.
CudaProbe probe_cuda(int device);

}  // namespace tessera
