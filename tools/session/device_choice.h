// What: --backend and --gpu, and what the machine has of CUDA → which backend, and why.
// Not: the making of it (backend_choice.h), nor any look at the machine.
#pragma once
#include <optional>
#include <string>

#include "kernels/device_probe.h"

namespace tessera {

struct BackendWish {
  std::string name = "auto";  // auto, cpu, cuda
  std::optional<int> gpu;     // number of the CUDA device
};

/// "auto", "cpu", "cuda", each but cpu also with a device's number: "cuda:1". Errors: InputError.
BackendWish parse_backend(const std::string& text);

/// What a choice rests on.
struct DeviceFacts {
  CudaProbe cuda;
  bool has_driver_module = false;              // the system has loaded NVIDIA's
  std::optional<std::string> visible_devices;  // CUDA_VISIBLE_DEVICES, where it is set
};

struct DeviceChoice {
  bool cuda = false;
  std::string reason;        // in words
  bool is_expected = false;  // on the CPU: there is nothing that CUDA could run on

  const char* kind() const { return cuda ? "cuda" : "cpu"; }
  /// On the CPU, although the machine looks as if CUDA could be used.
  bool leaves_cuda_unused() const { return !cuda && !is_expected; }
};

/// Errors: InputError: no device of that number; DeviceError: a device was asked for, and cannot be
/// used.
DeviceChoice choose_device(const BackendWish& wish, const DeviceFacts& facts);

}  // namespace tessera
