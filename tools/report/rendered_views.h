// The held-out views of a run beside what its model renders: of a training, or of a clip that was
// trained window by window.
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "kernels/backend.h"
#include "tools/clip/clip.h"
#include "tools/report/run_images.h"

namespace tessera {

class RenderedViews {
 public:
  /// `run`: a run folder, or the folder of a clip in windows. Errors: InputError: no model, windows
  /// that are not trained, a scene that is gone or has changed.
  RenderedViews(const std::filesystem::path& run,
                const std::function<std::unique_ptr<Backend>()>& backend);
  ~RenderedViews();

  /// What `tessera evaluate` prints of the first split that is held out, or of training.
  nlohmann::json scores();
  /// Nothing where the scene has no such view. The last window is kept, so that views ascending in
  /// time are the fastest. Errors: as load_model and load_scene.
  std::optional<RenderedView> view(const ScoredView& view);

 private:
  struct Loaded;

  /// The model and the held-out frames (those of training where nothing is held out) of a window.
  Loaded& load(int window);

  const std::filesystem::path scene_;
  Clip clip_;
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<Loaded> loaded_;
};

}  // namespace tessera
