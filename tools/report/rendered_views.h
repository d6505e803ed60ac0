// The held-out views of a run beside what its model renders: of a training, or of a clip that was
// trained window by window.
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "kernels/backend.h"
#include "tools/report/run_images.h"
#include "tools/session/windows_folder.h"

namespace tessera {

/// The scores of the windows in a folder.
using WindowsScorer = std::function<nlohmann::json(Backend&, const WindowsFolder&)>;

class RenderedViews {
 public:
  /// `run`: a run folder, or the folder of a clip in windows. Errors: InputError: no model, windows
  /// that are not trained, a scene that is gone.
  RenderedViews(const std::filesystem::path& run,
                const std::function<std::unique_ptr<Backend>()>& backend);
  ~RenderedViews();

  /// What `tessera evaluate` prints of it, of a clip in windows by `of_windows`; null where that is
  /// empty. Errors: as these.
  nlohmann::json scores(const WindowsScorer& of_windows);
  /// Nothing where the scene has no such view. Of a clip in windows the last window is kept, so
  /// that views ascending in time are the fastest. Errors: as load_model and load_scene.
  std::optional<RenderedView> view(const ScoredView& view);

 private:
  struct Loaded;

  /// The model and the held-out frames (those of training where nothing is held out) of a training.
  Loaded& load(const std::filesystem::path& run);

  const std::filesystem::path root_;
  const WindowsFolder windows_;
  std::vector<FileWindow> parts_;  // of a clip in windows
  std::filesystem::path scene_;
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<Loaded> loaded_;
};

}  // namespace tessera
