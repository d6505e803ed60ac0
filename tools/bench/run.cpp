// Names, fingerprints and result.json of runs. Folders are not locked: two programs may fill one
// folder when each has its own shard.
#include "tools/bench/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/errors.h"
#include "recon4d/evaluation/evaluate.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr Split kSplits[] = {Split::kTest, Split::kVal, Split::kTrain};

/// Names and sizes of the files of a folder, and the values in its JSON files: the same on machines
/// that have copies of it.
std::string folder_fingerprint(const fs::path& folder) {
  std::vector<std::string> lines;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    lines.push_back(fmt::format("{} {}", entry.path().lexically_relative(folder).generic_string(),
                                entry.file_size()));
    if (entry.path().extension() == ".json") lines.back() += read_text_file(entry.path());
  }
  std::sort(lines.begin(), lines.end());
  Fnv1a hash;
  for (const std::string& line : lines) {
    hash.add(line);
    hash.add("\n");
  }
  return hash.hex();
}

bool is_split(const std::string& text) {
  return std::any_of(std::begin(kSplits), std::end(kSplits),
                     [&](Split split) { return text == name_of(split); });
}

/// "dnerf_lego" of ".../dnerf_lego/".
std::string folder_name(const fs::path& path) {
  fs::path whole = fs::absolute(path).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  return whole.filename().string();
}

/// PATH or PATH:split. Without a split: test, else val. Errors: InputError: load_scene's; a split
/// without frames.
BenchScene open_bench_scene(const std::string& text) {
  BenchScene scene;
  scene.path = text;
  const size_t colon = text.rfind(':');
  if (!fs::exists(text) && colon != std::string::npos && is_split(text.substr(colon + 1))) {
    scene.path = text.substr(0, colon);
    scene.split = text.substr(colon + 1);
  }
  SceneOptions options;
  options.allow_static = true;
  options.load_pixels = false;
  const Scene loaded = load_scene(scene.path, options);
  for (Split split : kSplits)
    if (scene.split.empty() && split != Split::kTrain && !loaded.split_indices(split).empty())
      scene.split = name_of(split);
  if (scene.split.empty())
    throw InputError(
        fmt::format("{}: no frames are held out; score those of training with {}:train",
                    scene.path.string(), scene.path.string()));
  for (Split split : kSplits)
    if (scene.split == name_of(split) && loaded.split_indices(split).empty())
      throw InputError(fmt::format("{}: no frame in split '{}'; choose another of train, val, test",
                                   scene.path.string(), scene.split));
  scene.name = folder_name(scene.path);
  scene.facts = facts_of(loaded);
  scene.fingerprint = folder_fingerprint(scene.path);
  return scene;
}

}  // namespace

std::vector<BenchScene> open_bench_scenes(const std::vector<std::string>& texts) {
  std::vector<BenchScene> scenes;
  std::set<std::string> names;
  for (const std::string& text : texts) {
    scenes.push_back(open_bench_scene(text));
    if (!names.insert(scenes.back().name).second)
      throw InputError(
          fmt::format("bench: two scenes are named {}; rename a folder or give each its own -o",
                      scenes.back().name));
  }
  return scenes;
}

fs::path folder_of_run(const fs::path& root, const BenchRun& run) {
  return root / describe_run(run)["folder"].get<std::string>();
}

std::string run_fingerprint(const BenchRun& run) {
  Fnv1a hash;
  hash.add(json{kVersionText, to_json(run.options), run.scene.fingerprint, run.scene.split,
                run.score_at, run.scales}
               .dump());
  return hash.hex();
}

json describe_run(const BenchRun& run) {
  json described = {{"scene", run.scene.name},
                    {"scene_path", run.scene.path.string()},
                    {"split", run.scene.split},
                    {"label", run.label},
                    {"iterations", run.options.iterations},
                    {"seed", run.options.seed},
                    {"fingerprint", run_fingerprint(run)},
                    {"folder", fmt::format("runs/{}/{}{}/{}/{}", run.scene.name, run.label,
                                           run.score_at.empty() ? "" : "+curve",
                                           run.options.iterations, run.options.seed)},
                    {"status", "missing"}};
  if (!run.row.empty()) described["row"] = run.row;
  if (run.share > 0) described["share"] = run.share;
  if (!run.waits_for.empty()) described["error"] = run.waits_for;
  return described;
}

json recorded_run(const fs::path& root, json described) {
  const fs::path file = root / described["folder"].get<std::string>() / "result.json";
  std::error_code unreachable;
  if (!fs::is_regular_file(file, unreachable)) return described;
  json result = json::parse(read_text_file(file), nullptr, false);
  const std::string fingerprint = described["fingerprint"];
  if (!result.is_object() || result.value("fingerprint", "") != fingerprint) return described;
  described.erase("error");
  result.erase("row");  // runs of several tables are one
  described.update(result);
  return described;
}

}  // namespace tessera
