// Loads the MODEL argument of a command: a run folder, a checkpoint, a Tessera 4D .ply or 4D file,
// or splats of other programs.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "tools/session/windows_folder.h"

namespace tessera {

struct ModelInput {
  GaussianModel model;
  std::filesystem::path file;         // what was read
  int64_t bytes = 0;                  // its size
  bool with_optimizer = false;        // a checkpoint: its size is not the model's
  std::vector<std::string> warnings;  // one line each
};

/// By the first bytes; kSplats: a .ply without Tessera's comment, which may be a point cloud, .spz,
/// and .splat by its name. A Tessera 4D folder is known by its manifest.
enum class ModelKind { kNone, kCheckpoint, kTesseraPly, kTessera4d, kSplats };
ModelKind model_kind(const std::filesystem::path& file);

/// A run folder gives its model.ply, or checkpoint.ckpt when training has not ended, an OUT of
/// `tessera run` those of the run folder in it; a Tessera 4D folder itself: `file` is its manifest
/// then.
/// Errors: InputError naming the path and what is accepted.
ModelInput load_model_input(const std::filesystem::path& path);

/// A MODEL argument that is a clip in windows: their folder, an OUT of `tessera run` of them, or
/// their Tessera 4D file or folder; nothing where it is of one model.
/// Errors: as clip_models and open_tessera4d, at once or when a window is loaded.
std::optional<ClipModels> clip_of(const std::filesystem::path& path);

/// Another background, of --background's words, in place of the model's and of its environment; ""
/// leaves both. Errors: as parse_background.
void replace_background(const std::string& background, GaussianModel& model);

}  // namespace tessera
