// What: the backend that a name and this machine give, and why.
// Not: the decision (device_choice.h), nor a fallback where CUDA was asked for.
#pragma once
#include <memory>
#include <string>

#include "kernels/backend.h"
#include "tools/session/device_choice.h"

namespace tessera {

struct ChosenBackend {
  std::unique_ptr<Backend> backend;
  DeviceChoice choice;  // why this one
};

/// `backend`: as parse_backend. Makes nothing. Errors: InputError for another name or device,
/// DeviceError where CUDA or a device was asked for and cannot be used.
DeviceChoice find_backend(const std::string& backend);
/// "auto": the CUDA device where one can be used; else the CPU. Errors: as find_backend.
ChosenBackend choose_backend(const std::string& backend);

}  // namespace tessera
