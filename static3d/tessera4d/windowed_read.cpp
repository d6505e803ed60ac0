// Loads a file part by part; static blocks are decoded once. Tells such files from others.
#include <utility>

#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "static3d/tessera4d/block_sets.h"
#include "static3d/tessera4d/tessera4d.h"
#include "static3d/tessera4d/windowed_file.h"

namespace tessera {

bool is_tessera4d(std::string_view head) {
  return head.starts_with(kTessera4dMagic);
}

bool is_tessera4d_folder(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kTessera4dManifest;
  if (!std::filesystem::is_regular_file(path)) return false;
  const nlohmann::json manifest = read_json(path);
  return manifest.is_object() && manifest.value("format", nlohmann::json()) == kTessera4dFormat;
}

Tessera4dParts::Tessera4dParts(const std::filesystem::path& path)
    : container_(path), windows_(container_.manifest().windows) {
  if (windows_.empty()) windows_.push_back({{0, 1}, {0, 1}});
}

GaussianModel Tessera4dParts::load_static() {
  if (!fixed_)
    fixed_ = model_of_blocks(
        container_, [](const BlockInfo& block) { return !block.moving; }, warnings_);
  return fixed_->clone_values();
}

GaussianModel Tessera4dParts::load(int window) {
  check(window >= 0 && size_t(window) < windows_.size(), "Tessera4dParts: no such window");
  GaussianModel fixed = load_static();
  GaussianModel model = model_of_blocks(
      container_,
      [&](const BlockInfo& block) { return block.moving && std::max(block.window, 0) == window; },
      warnings_);
  model.static_set = std::move(fixed.static_set);
  apply_light(windows_[size_t(window)].light, model.static_set);
  model.nodes = std::move(fixed.nodes);
  model.time_axis = window_axis(windows_[size_t(window)], clip());
  return model;
}

Tessera4dParts open_tessera4d(const std::filesystem::path& path) {
  return Tessera4dParts(path);
}

}  // namespace tessera
