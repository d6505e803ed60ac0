// What: looks at the machine, chooses, makes the backend, and warns once of a choice that costs.
// Not: the decision and its words (device_choice.cpp).
#include "tools/session/backend_choice.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "kernels/base/errors.h"
#include "tools/cli/terminal.h"
#include "tools/session/device_choice.h"

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

void warn_once(const std::string& reason) {
  static bool warned = false;
  if (!std::exchange(warned, true))
    warn(fmt::format("CUDA is not used: {}; the CPU is used, which is much slower", reason));
}

DeviceChoice choose(const BackendWish& wish) {
  if (wish.name == "cpu") return choose_device(wish, {});
  const DeviceChoice choice = choose_device(wish, look_at_machine(wish));
  if (!choice.cuda && !choice.is_expected) warn_once(choice.reason);
  return choice;
}

}  // namespace

void add_backend_options(CLI::App& command, std::string& backend) {
  command
      .add_option("--backend", backend, "auto (a CUDA device where one can be used), cpu or cuda")
      ->default_str(backend);
  // after --backend: options are taken in this order
  command
      .add_option_function<std::string>(
          "--gpu", [&backend](const std::string& number) { backend += ":" + number; },
          "number of the CUDA device, of those that CUDA_VISIBLE_DEVICES shows; default: 0")
      ->type_name("N");
}

ChosenBackend choose_backend(const std::string& backend) {
  const BackendWish wish = parse_backend(backend);
  DeviceChoice choice = choose(wish);
  if (choice.cuda) {
    try {
      return {make_cuda_backend(wish.gpu.value_or(0)), "cuda", choice.reason};
    } catch (const DeviceError& error) {
      if (wish.name == "cuda" || wish.gpu) throw;
      choice = {false, error.what(), false};
      warn_once(choice.reason);
    }
  }
  return {make_cpu_backend(), "cpu", choice.reason};
}

std::unique_ptr<Backend> make_backend(const std::string& backend) {
  return choose_backend(backend).backend;
}

bool is_cuda_chosen(const std::string& backend) {
  return choose(parse_backend(backend)).cuda;
}

}  // namespace tessera
