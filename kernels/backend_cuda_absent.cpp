// What: stands in for the CUDA backend where it is not built; chosen by the linker.
// Not: a fallback: asking for CUDA without it is an error, never a silent change of backend.
#include "kernels/backend.h"
#include "kernels/base/errors.h"
#include "kernels/device_probe.h"

namespace tessera {

std::unique_ptr<Backend> make_cuda_backend(int) {
  throw DeviceError("this build has no CUDA backend; pass --backend cpu");
}

CudaProbe probe_cuda(int) {
  return {};
}

}  // namespace tessera
