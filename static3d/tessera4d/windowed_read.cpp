// Loads a file part by part; static blocks are decoded once.
#include "kernels/base/errors.h"
#include "static3d/tessera4d/block_sets.h"
#include "static3d/tessera4d/windowed_file.h"

namespace tessera {

Tessera4dParts::Tessera4dParts(const std::filesystem::path& path)
    : container_(path), windows_(container_.manifest().windows) {
  if (windows_.empty()) windows_.push_back({{0, 1}, {0, 1}});
}

GaussianModel Tessera4dParts::load(int window) {
  check(window >= 0 && size_t(window) < windows_.size(), "Tessera4dParts: no such window");
  if (!fixed_)
    fixed_ = model_of_blocks(
        container_, [](const BlockInfo& block) { return !block.moving; }, warnings_);
  GaussianModel model = model_of_blocks(
      container_,
      [&](const BlockInfo& block) { return block.moving && std::max(block.window, 0) == window; },
      warnings_);
  model.static_set = fixed_->static_set.clone_values();
  apply_light(windows_[size_t(window)].light, model.static_set);
  model.nodes = fixed_->nodes.clone_to(host_memory(), false);
  model.time_axis = window_axis(windows_[size_t(window)], clip());
  return model;
}

Tessera4dParts open_tessera4d(const std::filesystem::path& path) {
  return Tessera4dParts(path);
}

}  // namespace tessera
