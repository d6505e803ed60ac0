// Reads and clears a run folder; files that Tessera did not write are kept.
#include "tools/session/run_folder.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "kernels/base/errors.h"

namespace tessera {

std::string RunFolder::scene() const {
  return exists() ? read_config().value("scene", "") : "";
}

std::string RunFolder::static_model() const {
  if (!exists()) return "";
  const nlohmann::json shared = read_config().value("static_model", nlohmann::json::object());
  return shared.is_object() ? shared.value("run", "") : "";
}

std::optional<Window> RunFolder::window() const {
  if (!exists()) return std::nullopt;
  const std::string text = read_config().value("window", "");
  if (text.empty()) return std::nullopt;
  return window_of_text(text, config().string() + ": window");
}

nlohmann::json RunFolder::read_config() const {
  nlohmann::json config_file = nlohmann::json::parse(read_text_file(config()), nullptr, false);
  if (!config_file.is_object())
    throw InputError(
        fmt::format("{}: not valid JSON; train again with --overwrite", config().string()));
  return config_file;
}

std::filesystem::path RunFolder::best(int64_t iteration) const {
  return root / fmt::format("best_{:06}.ply", iteration);
}

void RunFolder::remove_best_but(int64_t iteration) const {
  static const std::regex kBest("best_[0-9]{6,}\\.ply");
  const std::string kept = best(iteration).filename().string();
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(root, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name != kept && std::regex_match(name, kBest))
      std::filesystem::remove(entry.path(), ignored);
  }
}

std::string RunFolder::made_for() const {
  try {
    return exists() ? read_config().value("made_for", "") : "";
  } catch (const InputError&) {
    return "";
  }
}

void RunFolder::require_room() const {
  if (std::filesystem::exists(root / "windows")) return;  // windows_folder.h
  if (exists()) {
    if (std::filesystem::exists(checkpoint()) || std::filesystem::exists(model()) ||
        !read_config().contains("options"))
      throw InputError(fmt::format(
          "{}: holds a run already; pass --resume to go on with it, or take another folder with -o",
          root.string()));
    return;
  }
  for (const std::filesystem::path& file : {model(), metrics(), exposure(), log()})
    if (std::filesystem::exists(file))
      throw InputError(fmt::format(
          "{}: no training has written this file, and it would be lost; move it away, or take "
          "another folder with -o",
          file.string()));
}

void RunFolder::remove_files() const {
  for (const std::filesystem::path& file :
       {config(), log(), checkpoint(), model(), exposure(), metrics()}) {
    std::error_code ignored;  // what cannot be removed fails with its reason when it is written
    std::filesystem::remove(file, ignored);
  }
  remove_best_but(-1);
}

std::filesystem::path run_folder_of(const std::filesystem::path& path) {
  const RunFolder inside{path / "run"};
  return !RunFolder{path}.exists() && inside.exists() ? inside.root : path;
}

namespace {

RunFolder run_of_model(const std::filesystem::path& model) {
  return {is_directory(model) ? run_folder_of(model) : model.parent_path()};
}

}  // namespace

std::string moved_scene(const std::filesystem::path& run, const std::filesystem::path& scene) {
  const std::filesystem::path root = std::filesystem::absolute(run / "").parent_path(),
                              above = root.parent_path();
  const struct {
    bool fits;
    std::filesystem::path place;
  } known[] = {{root.filename() == "run", above / "scene"},
               {root.filename().string().starts_with("seed-"),  // of a batch
                above.parent_path().parent_path().parent_path() / "scenes" / scene.filename()},
               {root.filename() == "static", above / "static_scene"},
               {above.filename() == "windows", above.parent_path().parent_path() / "scene"}};
  for (const auto& [fits, place] : known)
    if (fits && scene.filename() == place.filename() &&
        std::filesystem::exists(place / "transforms.json"))
      return place.string();
  return "";
}

namespace {

/// By the hash of its transforms.json, which runs of earlier versions do not have.
bool is_as_trained(const RunFolder& run, const std::filesystem::path& scene) {
  if (!run.exists()) return true;
  const std::string hash = run.read_config().value("scene_hash", "");
  const std::filesystem::path file = scene / "transforms.json";
  return hash.empty() || (std::filesystem::exists(file) && source_hash(file) == hash);
}

}  // namespace

std::string scene_of_model(const std::filesystem::path& model,
                           const std::vector<std::filesystem::path>& others) {
  const RunFolder run = run_of_model(model);
  const std::string scene = run.scene();
  std::vector<std::filesystem::path> known;
  if (!scene.empty()) known = {scene, moved_scene(run.root, scene)};
  known.insert(known.end(), others.begin(), others.end());
  std::erase_if(known, [](const auto& place) { return !std::filesystem::exists(place); });
  for (const std::filesystem::path& place : known)
    if (is_as_trained(run, place)) return place.string();
  return known.empty() ? "" : known.front().string();
}

std::string changed_scene(const std::filesystem::path& model, const std::string& scene) {
  const RunFolder run = run_of_model(model);
  if (scene.empty() || is_as_trained(run, scene)) return "";
  return fmt::format(
      "{}: was prepared again since {} was trained on it, and may hold out other cameras or have "
      "another size; train again, or pass the scene as it was by --scene",
      scene, run.root.string());
}

std::optional<Window> core_of_model(const std::filesystem::path& model,
                                    const std::filesystem::path& scene) {
  const RunFolder run = run_of_model(model);
  std::optional<Window> window = run.window();
  std::error_code absent;
  if (!window || !(std::filesystem::equivalent(scene_of_model(model), scene, absent) ||
                   is_as_trained(run, scene)))
    return std::nullopt;
  window->overlap = 0;
  return window;
}

}  // namespace tessera
