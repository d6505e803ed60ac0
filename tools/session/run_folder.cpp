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

}  // namespace tessera
