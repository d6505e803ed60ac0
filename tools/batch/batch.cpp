// Captures with their options, and the keys of batch.yaml.
#include "tools/batch/batch.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <thread>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "static3d/formats/splat_file.h"
#include "tools/batch/captures.h"
#include "tools/batch/given.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/command.h"
#include "tools/cli/ingest_arguments.h"
#include "tools/cli/output_place.h"
#include "tools/cli/terminal.h"
#include "tools/export/formats.h"
#include "tools/windows/window_choice.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::vector<std::string> kKeys = {"scenes", "captures",      "presets", "table",   "options",
                                        "seeds",  "budgets",       "steps",   "exports", "threads",
                                        "gpus",   "deterministic", "windows"};
constexpr const char* kGone[] = {"window_jobs", "tessera", "out"};  // of earlier versions

json json_of_scalar(const YAML::Node& node) {
  const std::string& text = node.Scalar();
  if (node.Tag() == "!") return text;  // in quotes
  if (text == "true" || text == "false") return text == "true";
  const char* const end = text.data() + text.size();
  int64_t whole = 0;
  double number = 0;
  if (std::from_chars(text.data(), end, whole).ptr == end) return whole;
  if (std::from_chars(text.data(), end, number).ptr == end) return number;
  return text;
}

json json_of(const YAML::Node& node) {
  json value;
  if (node.IsScalar()) return json_of_scalar(node);
  if (node.IsSequence()) {
    value = json::array();
    for (const YAML::Node& entry : node) value.push_back(json_of(entry));
  }
  if (node.IsMap()) {
    value = json::object();
    for (const auto& entry : node) value[entry.first.Scalar()] = json_of(entry.second);
  }
  return value;
}

/// Files that options name lie relative to batch.yaml, as captures do.
std::vector<std::string> with_whole_files(std::vector<std::string> words, const fs::path& folder) {
  for (size_t i = 0; i + 1 < words.size(); ++i)
    if (words[i] == "--poses" || words[i] == "--offsets" || words[i] == "--masks")
      if (const fs::path file = folder / words[i + 1]; fs::exists(file))
        words[i + 1] = file.lexically_normal().string();
  return words;
}

/// Errors: InputError: as `tessera ingest` of these words.
void check_ingest(std::vector<std::string> words, const std::string& where) {
  CLI::App command;
  IngestArguments arguments;
  arguments.options.frames_as = FramesAs::kAuto;
  add_ingest_options(command, arguments);
  command.add_flag("--static", arguments.options.allow_static);
  std::reverse(words.begin(), words.end());  // as CLI11 takes them
  try {
    command.parse(words);
    resolve_ingest(arguments);
  } catch (const CLI::ParseError& error) {
    throw InputError(fmt::format("{}: ingest: {}", where, error.what()));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: ingest: {}", where, error.what()));
  }
}

BatchScene read_scene(const json& entry, const fs::path& folder) {
  const json given = entry.is_string() ? json{{"path", entry}} : entry;
  if (!given.is_object() || !given.value("path", json()).is_string())
    throw InputError(
        fmt::format("scenes: {} has no `path`; write {{name: a, path: /data/a}}", entry.dump()));
  const std::string where = fmt::format("scenes: {}", given["path"].get<std::string>());
  check_keys(given, {"name", "path", "ingest", "split"}, where);
  BatchScene scene;
  scene.path = (folder / given["path"].get<std::string>()).lexically_normal();
  if (!scene.path.has_filename()) scene.path = scene.path.parent_path();
  scene.name = checked_name(given.contains("name") ? text_of_value(given["name"])
                                                   : safe_name(scene.path.filename().string()),
                            where);
  for (const json& word : given.value("ingest", json::array()))
    scene.ingest.push_back(text_of_value(word));
  scene.ingest = with_whole_files(std::move(scene.ingest), folder);
  check_ingest(scene.ingest, where);
  scene.split = given.value("split", json("")).is_null() ? "" : given.value("split", "");
  try {
    if (!scene.split.empty()) parse_split(scene.split);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: split: {}", where, error.what()));
  }
  return scene;
}

std::vector<BatchScene> read_scenes(const json& given, const fs::path& folder) {
  std::vector<BatchScene> scenes;
  for (const json& entry : list_at(given, "scenes", json::array()))
    scenes.push_back(read_scene(entry, folder));
  for (const std::string& pattern : names_at(given, "captures", json::array())) {
    try {
      for (const fs::path& path : folders_of_glob((folder / pattern).string(), folder))
        scenes.push_back(read_scene(json(path.string()), folder));
    } catch (const InputError& error) {
      throw InputError(fmt::format("captures: {}", error.what()));
    }
  }
  if (scenes.empty())
    throw InputError(
        "no scenes: give `captures: [/data/*/]`, or `scenes:` with a list of {name, path}");
  std::map<std::string, fs::path> names;
  for (const BatchScene& scene : scenes) {
    const auto [known, is_new] = names.emplace(scene.name, scene.path);
    if (!is_new)
      throw InputError(
          fmt::format("scenes: two are named '{}' ({} and {}); give one of them another `name`",
                      scene.name, known->second.string(), scene.path.string()));
    check_output_apart(folder, scene.path);
  }
  return scenes;
}

std::vector<std::string> read_exports(const json& given) {
  std::vector<std::string> known;
  for (const TimeFormat& format : time_formats()) known.emplace_back(format.name);
  for (const SplatFormat& format : splat_formats()) known.emplace_back(format.name);
  if (given.contains("exports") && given["exports"] == json::array()) return {};
  const std::vector<std::string> exports = names_at(given, "exports", {"tessera", "html"});
  for (const std::string& name : exports) check_known(name, known, "exports: unknown format");
  return exports;
}

}  // namespace

Batch resolve_batch(const json& given_keys, const fs::path& folder) {
  json given = given_keys;
  for (const char* key : kGone)
    if (given.erase(key) > 0)
      warn(fmt::format("batch.yaml: `{}` has no meaning any more and is passed over", key));
  for (auto it = given.begin(); it != given.end();) it = it->is_null() ? given.erase(it) : ++it;
  check_keys(given, kKeys, "batch.yaml");
  if (given.contains("deterministic") && !given["deterministic"].is_boolean())
    throw InputError("deterministic: expected true or false");
  Batch batch;
  batch.variants = read_variants(given);
  batch.seeds = numbers_at(given, "seeds", 0, {1});
  batch.exports = read_exports(given);
  batch.threads = number_of(given, "threads", 1, std::max(1u, std::thread::hardware_concurrency()));
  batch.gpus = number_of(given, "gpus", 0, 0);
  batch.windows = text_of_value(given.value("windows", json("auto")));
  try {
    parse_windows(batch.windows);
  } catch (const InputError& error) {
    throw InputError(fmt::format("windows: {}", error.what()));
  }
  batch.scenes = read_scenes(given, folder);
  return batch;
}

json read_batch_file(const fs::path& file) {
  if (!fs::is_regular_file(file))
    throw InputError(
        fmt::format("{}: is not there; name the captures of the batch", file.string()));
  const std::string text = read_text_file(file);
  json given = json::parse(text, nullptr, false);
  if (given.is_discarded()) try {
      given = json_of(YAML::Load(text));
    } catch (const YAML::Exception& error) {
      throw InputError(fmt::format("{}: is no YAML: {}", file.string(), error.what()));
    }
  if (!given.is_object())
    throw InputError(fmt::format("{}: expected `key: value` lines; there are {}", file.string(),
                                 fmt::join(kKeys, ", ")));
  return given;
}

json to_json(const Batch& batch) {
  json scenes = json::array(), variants = json::array();
  for (const BatchScene& scene : batch.scenes)
    scenes.push_back({{"name", scene.name},
                      {"path", scene.path.string()},
                      {"ingest", scene.ingest},
                      {"split", scene.split}});
  for (const BatchVariant& variant : batch.variants)
    variants.push_back({{"name", variant.name},
                        {"preset", variant.arguments.preset},
                        {"ablation", variant.arguments.ablation},
                        {"options", variant.arguments.given},
                        {"label", variant.label},
                        {"published", variant.published}});
  return {{"scenes", scenes},
          {"variants", variants},
          {"seeds", batch.seeds},
          {"exports", batch.exports},
          {"windows", batch.windows}};
}

}  // namespace tessera
