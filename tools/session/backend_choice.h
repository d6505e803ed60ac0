// What: --backend and --gpu on the command line → Backend.
// Not: the decision (device_choice.h); nor a fallback where CUDA was asked for.
#pragma once
#include <memory>
#include <string>

#include "kernels/backend.h"

namespace CLI {
class App;
}

namespace tessera {

/// --backend and --gpu; `backend` becomes "auto", "cpu", "cuda", with a number "auto:1".
void add_backend_options(CLI::App& command, std::string& backend);

struct ChosenBackend {
  std::unique_ptr<Backend> backend;
  std::string kind;    // "cpu", "cuda"
  std::string reason;  // why this one
};

/// "auto": the CUDA device where one can be used; else the CPU, with one warning a program that
/// says why, unless there is nothing that CUDA could run on. Errors: InputError for another name or
/// device, DeviceError where CUDA or a device was asked for and cannot be used.
ChosenBackend choose_backend(const std::string& backend);
std::unique_ptr<Backend> make_backend(const std::string& backend);
/// Whether it would be a CUDA device. Warns and fails as choose_backend, but makes nothing.
bool is_cuda_chosen(const std::string& backend);

}  // namespace tessera
