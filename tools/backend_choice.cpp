// What: the table of backends by name.
// Not: any preference but a device over the CPU where the user has none.
#include "tools/backend_choice.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"

namespace tessera {

namespace {

std::unique_ptr<Backend> make_best_backend() {
  try {
    return make_cuda_backend();
  } catch (const DeviceError&) {  // no device, or a build without CUDA
    return make_cpu_backend();
  }
}

}  // namespace

std::unique_ptr<Backend> make_backend(const std::string& name) {
  if (name == "auto") return make_best_backend();
  if (name == "cpu") return make_cpu_backend();
  if (name == "cuda") return make_cuda_backend();
  throw InputError(fmt::format("unknown backend '{}'; choose auto, cpu or cuda", name));
}

}  // namespace tessera
