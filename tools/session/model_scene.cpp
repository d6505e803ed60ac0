// Scenes are told by the hash of their transforms.json, which runs of early versions do not have.
#include "tools/session/model_scene.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "ingest/files/fnv1a.h"
#include "kernels/base/errors.h"
#include "tools/session/run_folder.h"
#include "tools/session/windows_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// What a file holds; discarded where it is not there or no JSON.
json json_in(const fs::path& file) {
  std::ifstream text(file);
  return json::parse(text, nullptr, false);
}

/// A training that names its scene.
struct Trained {
  RunFolder run;                // of several windows that of the first
  fs::path named_by;            // the file that names the scene
  std::vector<fs::path> known;  // where the scene may be
  bool in_windows = false;
};

/// `scene` of the folder `run`, which was moved with it: the scene in the OUT of `tessera run`, of
/// its run, of the windows of a clip in that run, or of the static set of these. "" where none lies
/// there.
fs::path moved_scene(const fs::path& run, const fs::path& scene) {
  const fs::path root = fs::absolute(run / "").parent_path(), above = root.parent_path();
  const struct {
    bool fits;
    fs::path place;
  } known[] = {{root.filename() == "run", above / "scene"},
               {root.filename().string().starts_with("seed-"),  // of a batch
                above.parent_path().parent_path().parent_path() / "scenes" / scene.filename()},
               {root.filename() == "static", above / "static_scene"},
               {above.filename() == "windows", above.parent_path().parent_path() / "scene"}};
  for (const auto& [fits, place] : known)
    if (fits && scene.filename() == place.filename() && fs::exists(place / "transforms.json"))
      return place;
  return {};
}

Trained trained(const fs::path& model) {
  Trained found;
  const auto add = [&](const fs::path& folder, const fs::path& scene) {
    if (scene.empty()) return;
    found.known.push_back(scene);
    if (const fs::path moved = moved_scene(folder, scene); !moved.empty())
      found.known.push_back(moved);
  };
  const WindowsFolder windows = windows_folder_of(model);
  found.in_windows = windows.exists();
  found.run = {found.in_windows          ? windows.window_run(0)
               : fs::is_directory(model) ? run_folder_of(model)
                                         : model.parent_path()};
  found.named_by = found.in_windows ? windows.plan_file() : found.run.config();
  add(found.run.root, found.run.scene());
  if (found.in_windows) add(windows.root, windows.read().scene);
  return found;
}

bool is_as_trained(const RunFolder& run, const fs::path& scene) {
  if (!run.exists()) return true;
  const std::string hash = run.read_config().value("scene_hash", "");
  const fs::path file = scene / "transforms.json";
  return hash.empty() || (fs::exists(file) && source_hash(file) == hash);
}

std::string scene_of(const Trained& model) {
  std::string first;
  for (const fs::path& place : model.known) {
    if (!fs::exists(place)) continue;
    if (is_as_trained(model.run, place)) return place.string();
    if (first.empty()) first = place.string();
  }
  return first;
}

}  // namespace

std::string scene_of_model(const fs::path& model) {
  return scene_of(trained(model));
}

fs::path require_scene_of(const fs::path& model) {
  const Trained found = trained(model);
  if (const std::string scene = scene_of(found); !scene.empty()) return scene;
  if (found.known.empty())
    throw InputError(
        fmt::format("{}: no run folder that names its scene; pass --scene FOLDER", model.string()));
  throw InputError(fmt::format("{}: its scene {} is gone; pass --scene FOLDER",
                               found.named_by.string(), found.known.front().string()));
}

bool is_run_output(const fs::path& folder) {
  const json stages = json_in(folder / "stages.json");
  return stages.is_object() && (stages.contains("asked") || stages.contains("ingest"));
}

void refuse_trained(const fs::path& folder, const char* what) {
  const json config = json_in(folder / "config.json");
  const bool is_run = config.is_object() && config.value("options", json()).is_object() &&
                      config.value("scene", json()).is_string();
  if (!is_run && !is_run_output(folder)) return;
  const std::string scene = scene_of_model(folder);
  throw InputError(fmt::format(
      "{0}: is what a training made, no {1}; look at it: tessera view {0}{2}", folder.string(),
      what, scene.empty() ? "" : "; the scene that it was trained on: " + scene));
}

std::string changed_scene(const fs::path& model, const std::string& scene) {
  const RunFolder run = trained(model).run;
  if (scene.empty() || is_as_trained(run, scene)) return "";
  return fmt::format(
      "{}: was prepared again since {} was trained on it, and may hold out other cameras or have "
      "another size; train again, or pass the scene as it was by --scene",
      scene, run.root.string());
}

std::optional<Window> core_of_model(const fs::path& model, const fs::path& scene) {
  const Trained found = trained(model);
  std::optional<Window> window = found.in_windows ? std::nullopt : found.run.window();
  std::error_code absent;
  if (!window ||
      !(fs::equivalent(scene_of(found), scene, absent) || is_as_trained(found.run, scene)))
    return std::nullopt;
  window->overlap = 0;
  return window;
}

}  // namespace tessera
