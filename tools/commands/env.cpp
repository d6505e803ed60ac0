// `tessera env`: versions, build, devices and helper programs, for bug reports.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "ingest/ingest.h"
#include "kernels/device_probe.h"
#include "tools/cli/command.h"
#include "tools/cli/terminal.h"
#include "tools/session/device_choice.h"
#include "tools/session/version.h"
#include "tools/web/web_page.h"

namespace tessera {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string cuda_version(int version) {
  return version == 0 ? "none" : fmt::format("{}.{}", version / 1000, version % 1000 / 10);
}

/// The value of the first line of a file that begins with `key`; "unknown" without one.
std::string line_value(const char* file, const std::string& key, char separator) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(key)) {
      const size_t begin = line.find_first_not_of(" \t\"", line.find(separator) + 1);
      const size_t end = line.find_last_not_of(" \t\"");
      return begin == std::string::npos ? "unknown" : line.substr(begin, end - begin + 1);
    }
  return "unknown";
}

/// Where a helper program is found; "not found" otherwise.
std::string program_path(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const fs::path file = fs::path(folder) / name; ::access(file.c_str(), X_OK) == 0)
      return file.string();
  return "not found";
}

json cuda_facts() {
  const CudaProbe cuda = probe_cuda(0);
  json devices = json::array();
  for (const CudaDevice& device : cuda.devices)
    devices.push_back(fmt::format("{} (sm_{})", device.name, device.architecture));
  DeviceFacts facts{cuda, fs::exists("/proc/driver/nvidia/version"), std::nullopt};
  return {{"built_for", cuda.architectures},
          {"runtime", cuda_version(cuda.runtime_version)},
          {"driver_supports", cuda_version(cuda.driver_version)},
          {"devices", devices},
          {"usable", cuda.failure == CudaFailure::kNone},
          {"reason", choose_device({}, facts).reason}};
}

json facts() {
  utsname system{};
  uname(&system);
  json libraries = json::object(), programs = json::object();
  for (const auto& [name, version] : media_versions()) libraries[name] = version;
  for (const char* name : {"colmap", "snakemake", "ffmpeg"}) programs[name] = program_path(name);
  return {{"version", kVersionText},
          {"commit", kCommitText},
          {"compiler", kCompilerText},
          {"build", kBuildText},
          {"system", line_value("/etc/os-release", "PRETTY_NAME", '=')},
          {"kernel", fmt::format("{} {}", system.release, system.machine)},
          {"cpu", cpu_name()},
          {"threads", std::thread::hardware_concurrency()},
          {"memory_gib", double(machine_memory()) / double(1 << 30)},
          {"cuda", cuda_facts()},
          {"player_page", carries_pages()},
          {"libraries", libraries},
          {"programs", programs}};
}

std::string text_of(const json& facts) {
  const auto line = [](const std::string& key, const std::string& value) {
    return fmt::format("{:<12} {}\n", key, value);
  };
  const auto text = [&](const char* key) { return facts[key].get<std::string>(); };
  const json& cuda = facts["cuda"];
  std::string result = line("tessera", text("version") + " (" + text("commit") + ")");
  result += line("build", text("build") + ", " + text("compiler"));
  result += line("system", text("system") + ", Linux " + text("kernel"));
  result += line("cpu", fmt::format("{}, {} threads, {:.1f} GiB", text("cpu"),
                                    facts["threads"].dump(), facts["memory_gib"].get<double>()));
  std::vector<std::string> cards;
  for (const json& card : cuda["built_for"]) cards.push_back("sm_" + card.dump());
  result += line(
      "cuda", cards.empty() ? "not built"
                            : fmt::format("runtime {}, for {}; driver supports {}",
                                          cuda["runtime"].get<std::string>(), fmt::join(cards, " "),
                                          cuda["driver_supports"].get<std::string>()));
  for (const json& device : cuda["devices"]) result += line("gpu", device.get<std::string>());
  result +=
      line("backend",
           cuda["usable"].get<bool>() ? "cuda" : "cpu (" + cuda["reason"].get<std::string>() + ")");
  result += line("player", facts["player_page"].get<bool>() ? "built" : "not built");
  for (const char* group : {"libraries", "programs"})
    for (const auto& [name, value] : facts[group].items())
      result += line(name, value.get<std::string>());
  result.pop_back();
  return result;
}

}  // namespace

void add_env_command(CLI::App& app, Work& work) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand(
      "env", "print versions, build, devices and helper programs, for bug reports");
  command->add_flag("--json", *as_json, "print one JSON object");
  command->callback([as_json, &work] {
    work = [as_json] {
      const json found = facts();
      print_result(*as_json, found, text_of(found));
      return int(kExitDone);
    };
  });
}

}  // namespace tessera
