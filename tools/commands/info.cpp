// `tessera info` prints the contents of a file or folder (describe.h).
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/cli/command.h"
#include "tools/cli/terminal.h"
#include "tools/commands/describe.h"
#include "tools/session/held_out_scores.h"

namespace tessera {
namespace {

struct InfoRequest {
  std::string path;
  bool shipped = false, json = false;
};

std::string value_text(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (!value.is_array()) return value.is_null() ? "none" : value.dump();
  std::string text;
  for (const nlohmann::json& item : value)
    text += (text.empty() ? "" : ", ") + (item.is_object() ? item.dump() : value_text(item));
  return text;
}

/// "min 0.1, max 0.9": for small objects of plain values.
std::string inline_text(const nlohmann::json& object) {
  std::string text;
  for (const auto& [key, value] : object.items())
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", key, value_text(value));
  return text;
}

bool fits_a_line(const nlohmann::json& object) {
  constexpr size_t kMost = 7;
  return object.size() <= kMost && std::all_of(object.begin(), object.end(), [](const auto& value) {
           return value.is_number() || value.is_boolean() || value.is_null();
         });
}

/// "name  value" a line; larger objects are indented below their name.
void add_lines(const nlohmann::json& object, const std::string& indent, std::string& text) {
  size_t longest = 0;
  for (const auto& [key, value] : object.items()) longest = std::max(longest, key.size());
  for (const auto& [key, value] : object.items()) {
    if (!value.is_object() || fits_a_line(value)) {
      text += fmt::format("{}{:<{}}  {}\n", indent, key, longest,
                          value.is_object() ? inline_text(value) : value_text(value));
    } else {
      text += fmt::format("{}{}\n", indent, key);
      add_lines(value, indent + "  ", text);
    }
  }
}

/// "preset balanced, 7000 steps, seed 1, NVIDIA H200, tessera 0.4.0".
std::string training_text(const nlohmann::json& config) {
  const nlohmann::json options = config.value("options", nlohmann::json::object());
  return fmt::format("preset {}, {} steps, seed {}, {}, tessera {}",
                     value_text(config.value("preset", nlohmann::json())),
                     value_text(options.value("iterations", nlohmann::json())),
                     value_text(config.value("seed", nlohmann::json())),
                     value_text(config.value("device", nlohmann::json())),
                     value_text(config.value("tessera", nlohmann::json())));
}

/// Of a model, what people ask for first; the others by their number.
std::string model_text(const nlohmann::json& info) {
  std::string text;
  const auto add = [&](const char* name, const std::string& value) {
    text += fmt::format("  {:<11}{}\n", name, value);
  };
  add("Gaussians", fmt::format("{} static, {} dynamic", value_text(info.at("num_static")),
                               value_text(info.at("num_dynamic"))));
  if (info.contains("motion_nodes")) add("nodes", inline_text(info["motion_nodes"]));
  if (info.contains("time_axis"))
    add("clip", fmt::format("{:.4g} s", info["time_axis"].value("duration", 0.0)));
  if (info.contains("sh_degree")) add("SH degree", value_text(info["sh_degree"]));
  if (info.contains("bytes")) add("size", size_text(info["bytes"].get<int64_t>()));
  if (info.contains("shipped_bytes"))
    add("exported", size_text(info["shipped_bytes"].get<int64_t>()));
  if (info.contains("iteration")) add("iteration", value_text(info["iteration"]));
  if (info.contains("config")) add("training", training_text(info["config"]));
  if (info.contains("scores"))
    add("scores",
        fmt::format("{}: PSNR {} dB, SSIM {}", views_text(value_text(info["scores"]["split"])),
                    number_text(info["scores"]["psnr"], 2),
                    number_text(info["scores"]["ssim"], 4)));
  for (const char* key : {"scene", "file"})
    if (info.contains(key)) add(key, value_text(info[key]));
  return text +
         fmt::format("  {:<11}tessera info {} -v", "all facts", info.at("path").get<std::string>());
}

/// What it is in the first line, the facts below.
std::string info_text(nlohmann::json info) {
  std::string text = fmt::format("{}: {}\n", info.at("path").get<std::string>(),
                                 info.at("kind").get<std::string>());
  if (info.contains("num_static") && info.contains("num_dynamic") && !is_verbose())
    return text + model_text(info);
  info.erase("path");
  info.erase("kind");
  add_lines(info, "  ", text);
  text.pop_back();
  return text;
}

}  // namespace

void add_info_command(CLI::App& app, Work& work) {
  CLI::App* command =
      app.add_subcommand("info", "describe a model, checkpoint, scene or splat file");
  const auto request = std::make_shared<InfoRequest>();
  command
      ->add_option(
          "path", request->path,
          "model, splat or cloud .ply, checkpoint, output of `tessera run`, run folder, scene or "
          "capture")
      ->required();
  command->add_flag(
      "--shipped", request->shipped,
      "of a model: the bytes of the Tessera 4D file that export would write; encodes it, "
      "three seconds of a core for 100,000 Gaussians");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] {
    work = [request] {
      const nlohmann::json info = describe(request->path, request->shipped);
      print_result(request->json, info, request->json ? "" : info_text(info));
      return int(kExitDone);
    };
  });
}

}  // namespace tessera
