// What: --backend on the command line → Backend.
// Not: a fallback: asking for CUDA where there is none is an error.
#pragma once
#include <memory>
#include <string>

#include "kernels/backend.h"

namespace tessera {

/// "cpu" or "cuda". Errors: InputError for another name, DeviceError where there is no CUDA.
std::unique_ptr<Backend> make_backend(const std::string& name);

}  // namespace tessera
