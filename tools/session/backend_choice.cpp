// What: looks at the machine, chooses and makes the backend.
// Not: the decision and its words (device_choice.cpp).
#include "tools/session/backend_choice.h"

#include <cstdlib>
#include <filesystem>
#include <utility>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// NVIDIA's kernel module is there: on Linux, and as Windows shows it to WSL.
bool has_driver_module() {
  for (const char* path : {"/proc/driver/nvidia/version", "/dev/nvidiactl", "/dev/dxg"}) {
    std::error_code unreachable;
    if (std::filesystem::exists(path, unreachable)) return true;
  }
  return false;
}

DeviceFacts look_at_machine(const BackendWish& wish) {
  DeviceFacts facts{probe_cuda(wish.gpu.value_or(0)), has_driver_module(), std::nullopt};
  if (const char* const visible = std::getenv("CUDA_VISIBLE_DEVICES"))
    facts.visible_devices = visible;
  return facts;
}

DeviceChoice find(const BackendWish& wish) {
  return choose_device(wish, wish.name == "cpu" ? DeviceFacts{} : look_at_machine(wish));
}

}  // namespace

DeviceChoice find_backend(const std::string& backend) {
  return find(parse_backend(backend));
}

ChosenBackend choose_backend(const std::string& backend) {
  const BackendWish wish = parse_backend(backend);
  DeviceChoice choice = find(wish);
  if (choice.cuda) {
    try {
      return {make_cuda_backend(wish.gpu.value_or(0)), choice};
    } catch (const DeviceError& error) {
      if (wish.name == "cuda" || wish.gpu) throw;
      choice = {false, error.what(), false};
    }
  }
  return {make_cpu_backend(), choice};
}

}  // namespace tessera
