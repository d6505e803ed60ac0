// The substitute that the linker takes where the CUDA backend is not built. A request for CUDA is
// then an error and never a silent change of backend.
#include "kernels/backend.h"
#include "kernels/base/errors.h"
#include "kernels/device_probe.h"

namespace tessera {

std::unique_ptr<Backend> make_cuda_backend(int) {
  throw DeviceError(
      "this build has no CUDA backend (cmake --preset release-cuda makes one); pass --backend cpu");
}

CudaProbe probe_cuda(int) {
  return {};
}

}  // namespace tessera
