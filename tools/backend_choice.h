// What: --backend on the command line → Backend.
// Not: a fallback where CUDA was asked for: that is an error if there is none.
#pragma once
#include <memory>
#include <string>

#include "kernels/backend.h"

namespace tessera {

/// "auto": a CUDA device where there is one, else the CPU; "cpu"; "cuda". Errors: InputError for
/// another name, DeviceError where there is no CUDA.
std::unique_ptr<Backend> make_backend(const std::string& name);

}  // namespace tessera
