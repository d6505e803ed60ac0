// Chooses the backend from --backend, --gpu and the CUDA devices of the machine, with the reason,
// and makes it. Also facts of the machine and of this process from the operating system.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kernels/backend.h"
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

struct ChosenBackend {
  std::unique_ptr<Backend> backend;
  DeviceChoice choice;  // why this one
};

/// `backend`: as parse_backend. Makes nothing. Errors: InputError for another name or device,
/// DeviceError where CUDA or a device was asked for and cannot be used.
DeviceChoice find_backend(const std::string& backend);
/// "auto": the CUDA device where one can be used; else the CPU. Errors: as find_backend.
ChosenBackend choose_backend(const std::string& backend);

/// Bytes of memory that programs can have in all: those of the machine, or fewer where a container
/// or a queue allows this one fewer.
int64_t machine_memory();
/// The least memory that a cgroup and those around it allow; nothing where none has a limit. `own`:
/// as /proc/self/cgroup, of version 1 or 2; `root`: /sys/fs/cgroup.
std::optional<int64_t> memory_limit(const std::string& own, const std::filesystem::path& root);

/// The name of the processor, as /proc/cpuinfo has it; "unknown" where it has none.
std::string cpu_name();

/// The words by which this process was started; empty where the system does not list them.
std::vector<std::string> command_line();

/// Now, in UTC and as ISO 8601 has it: "2026-11-24T09:30:00Z".
std::string utc_time();

}  // namespace tessera
