// The reasons for each choice as text, and reads of the system's calls and of /proc.
#include "tools/session/device_choice.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

std::string version_text(int version) {
  return fmt::format("{}.{}", version / 1000, version % 1000 / 10);
}

std::string architectures_text(const std::vector<int>& architectures) {
  std::string text;
  for (const int one : architectures) text += fmt::format("{}sm_{}", text.empty() ? "" : ", ", one);
  return text;
}

/// "; CUDA_VISIBLE_DEVICES is '0,1'" where it is set.
std::string visibility(const DeviceFacts& facts, const char* before) {
  return facts.visible_devices
             ? fmt::format("{}CUDA_VISIBLE_DEVICES is '{}'", before, *facts.visible_devices)
             : "";
}

std::string no_kernels(const CudaProbe& cuda) {
  const CudaDevice& card = cuda.devices.at(size_t(cuda.tried));
  return fmt::format(
      "this build has kernels for {} only, the card {} is sm_{}; rebuild with "
      "-DCMAKE_CUDA_ARCHITECTURES={}, or with --preset gpu for every card",
      architectures_text(cuda.architectures), card.name, card.architecture, card.architecture);
}

/// Why CUDA cannot be used.
std::string reason_of(const DeviceFacts& facts) {
  const CudaProbe& cuda = facts.cuda;
  switch (cuda.failure) {
    case CudaFailure::kNone:
      return "";
    case CudaFailure::kNotBuilt:
      return facts.has_driver_module
                 ? "this build has no CUDA backend, but the machine has an NVIDIA driver; "
                   "configure with -DTESSERA_CUDA=ON"
                 : "this build has no CUDA backend";
    case CudaFailure::kNoDriver:
      return facts.has_driver_module
                 ? "the library of the NVIDIA driver (libcuda.so.1) is not found; install it, or "
                   "start the container with its GPU (docker run --gpus all)"
                 : "no NVIDIA driver is installed";
    case CudaFailure::kOldDriver:
      return fmt::format(
          "the NVIDIA driver is too old: it supports CUDA {}, this build needs {}; update the "
          "driver",
          version_text(cuda.driver_version), version_text(cuda.runtime_version));
    case CudaFailure::kNoDevice:
      return "the NVIDIA driver shows no device" + visibility(facts, ": ");
    case CudaFailure::kNoKernels:
      return no_kernels(cuda);
    case CudaFailure::kNoMemory:
      return fmt::format(
          "device {} ({}) has too little free memory to begin with; end what runs on it (see "
          "nvidia-smi){}",
          cuda.tried, cuda.devices.at(size_t(cuda.tried)).name,
          cuda.devices.size() > 1 ? ", or choose another one by --gpu" : "");
    case CudaFailure::kOther:
      return "CUDA reports: " + cuda.error;
  }
  return cuda.error;
}

/// Nothing that a user of this machine would miss.
bool is_expected(const DeviceFacts& facts) {
  const CudaFailure failure = facts.cuda.failure;
  return !facts.has_driver_module &&
         (failure == CudaFailure::kNotBuilt || failure == CudaFailure::kNoDriver);
}

void check_number(const BackendWish& wish, const DeviceFacts& facts) {
  const std::vector<CudaDevice>& devices = facts.cuda.devices;
  if (!wish.gpu || devices.empty() || size_t(*wish.gpu) < devices.size()) return;
  std::string list;
  for (size_t i = 0; i < devices.size(); ++i)
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", i, devices[i].name);
  throw InputError(fmt::format("--gpu {}: there is no such CUDA device, expected one of: {}{}",
                               *wish.gpu, list, visibility(facts, "; ")));
}

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

BackendWish parse_backend(const std::string& text) {
  const size_t colon = text.find(':');
  BackendWish wish{text.substr(0, colon), std::nullopt};
  if (wish.name != "auto" && wish.name != "cpu" && wish.name != "cuda")
    throw InputError(fmt::format("unknown backend '{}'; choose auto, cpu or cuda", text));
  if (colon == std::string::npos) return wish;
  const char* const end = text.data() + text.size();
  int number = -1;
  const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, number);
  if (error != std::errc() || rest != end || number < 0)
    throw InputError(fmt::format("--gpu {}: expected the number of a CUDA device, from 0 on",
                                 text.substr(colon + 1)));
  if (wish.name == "cpu")
    throw InputError("--gpu chooses a CUDA device, and --backend is cpu; drop one of the two");
  wish.gpu = number;
  return wish;
}

DeviceChoice choose_device(const BackendWish& wish, const DeviceFacts& facts) {
  if (wish.name == "cpu") return {false, "--backend cpu", true};
  check_number(wish, facts);
  const CudaProbe& cuda = facts.cuda;
  if (cuda.failure == CudaFailure::kNone)
    return {true, fmt::format("device {} of {} can be used", cuda.tried, cuda.devices.size()),
            false};
  if (wish.gpu)
    throw DeviceError(fmt::format("--gpu {} cannot be used: {}", *wish.gpu, reason_of(facts)));
  if (wish.name == "cuda")
    throw DeviceError(
        fmt::format("CUDA cannot be used: {}; --backend cpu does without", reason_of(facts)));
  return {false, reason_of(facts), is_expected(facts)};
}

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

std::optional<int64_t> memory_limit(const std::string& own, const std::filesystem::path& root) {
  std::optional<int64_t> least;
  const auto look = [&](const std::filesystem::path& folder, const std::string& group,
                        const char* file) {
    for (std::filesystem::path place = group;; place = place.parent_path()) {
      int64_t limit = 0;  // "max" is none
      if (std::ifstream(folder / place.relative_path() / file) >> limit && limit > 0)
        least = std::min(least.value_or(limit), limit);
      if (place == place.parent_path()) break;
    }
  };
  std::istringstream lines(own);
  for (std::string line; std::getline(lines, line);) {  // number:controllers:path
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (controllers.empty())
      look(root, line.substr(second + 1), "memory.max");
    else if (("," + controllers + ",").find(",memory,") != std::string::npos)
      look(root / "memory", line.substr(second + 1), "memory.limit_in_bytes");
  }
  return least;
}

int64_t machine_memory() {
  const int64_t machine = int64_t(::sysconf(_SC_PHYS_PAGES)) * int64_t(::sysconf(_SC_PAGESIZE));
  std::ostringstream own;
  own << std::ifstream("/proc/self/cgroup").rdbuf();
  return std::min(machine, memory_limit(own.str(), "/sys/fs/cgroup").value_or(machine));
}

std::string cpu_name() {
  std::ifstream facts("/proc/cpuinfo");
  for (std::string line; std::getline(facts, line);)
    if (line.starts_with("model name"))
      if (const size_t colon = line.find(": "); colon != std::string::npos)
        return line.substr(colon + 2);
  return "unknown";
}

std::vector<std::string> command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

std::string utc_time() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  char text[32] = {};
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace tessera
