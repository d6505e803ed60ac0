// The MODEL argument of a command as the windows of a clip: a run folder, the folder of a clip that
// was trained window by window, a checkpoint, a Tessera 4D .ply or 4D file, or splats of other
// programs. A clip has at least one window.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {

struct Clip {
  std::filesystem::path named;  // the argument
  std::filesystem::path file;   // what was read; of windows that were trained their folder
  WindowModels windows;         // one is loaded at a time; the whole clip where it is of one model
  /// Of several windows: the static set that they share, in the light of none of them, with the
  /// time axis of the clip.
  std::function<GaussianModel()> load_static;
  /// The rules, the world and the time axis of the clip, with the Gaussians of one model or of the
  /// first window in which something moves.
  std::shared_ptr<GaussianModel> head;
  std::optional<int64_t> bytes;       // of the model's file; nothing: a checkpoint, a folder
  std::filesystem::path stills;       // the scene of what stands still in the clip; "": not known
  std::vector<std::string> warnings;  // one line each

  int64_t count() const { return int64_t(windows.windows.size()); }
  /// Every model is changed so when it is loaded, the head at once.
  void edit(const std::function<void(GaussianModel&)>& change);
};

/// A run folder gives its model.ply, or checkpoint.ckpt when training has not ended, an OUT of
/// `tessera run` those of the run folder in it.
/// Errors: InputError naming the path and what is accepted; windows that are not trained; as
/// load_model, at once or when a window is loaded.
Clip load_clip(const std::filesystem::path& path);

/// By the first bytes; kLines: 4D splats of other programs; kSplats: a .ply without Tessera's
/// comment, which may be a point cloud, .spz, and .splat by its name. A Tessera 4D folder is known
/// by its manifest.
enum class ModelKind { kNone, kCheckpoint, kTesseraPly, kTessera4d, kLines, kSplats };
ModelKind model_kind(const std::filesystem::path& file);
inline bool is_of_other_program(ModelKind kind) {
  return kind == ModelKind::kLines || kind == ModelKind::kSplats;
}

/// Another background, of --background's words, in place of the model's and of its environment; ""
/// leaves both. Errors: as parse_background.
void replace_background(const std::string& background, GaussianModel& model);

}  // namespace tessera
