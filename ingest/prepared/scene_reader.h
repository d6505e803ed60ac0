// Loads a prepared scene, or a D-NeRF or NeRF-synthetic folder, as a Scene. It needs no FFmpeg,
// OpenCV or OpenImageIO.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "ingest/clocks/windows.h"
#include "ingest/scene.h"

namespace tessera {

struct SceneOptions {
  std::array<uint8_t, 3> background{0, 0, 0};  // RGBA frames are composited on it, once, here
  bool allow_static = false;                   // accept times that are all equal as one timestep
  bool load_pixels = true;                     // false: as scene_without_pixels
  // Pixels of these splits only, and of the other frames of their cameras that stand still, whose
  // medians over time tell what moves.
  std::optional<std::vector<Split>> pixels_of = {};
  // The frames of this part of the clip alone; times and numbers of timesteps are those of a clip
  // that has no others. It has no cloud where that of the clip says what stands still.
  std::optional<Window> window = {};
  // Times and numbers of timesteps stay those of the clip with any of these.
  // Only the training frames of these timesteps, by Frame::timestep.
  std::optional<std::vector<int64_t>> timesteps = {};
  std::optional<int64_t> held_out = {};  // N frames of the first split that has some of test, val,
                                         // train
  std::optional<std::vector<int>> frames = {};  // these, by their place in the whole scene
};

struct ListedScene;

/// A scene whose json and points are read once, and whose frames are read as they are asked for.
class SceneFiles {
 public:
  /// Errors: those of load_scene that come before its images.
  SceneFiles(const std::filesystem::path& folder, bool allow_static,
             const std::optional<Window>& window = {});
  ~SceneFiles();
  /// As load_scene, with the allow_static and window of the constructor. Threads may call it at
  /// once.
  Scene load(const SceneOptions& options) const;

 private:
  std::unique_ptr<const ListedScene> listed_;
};

/// Errors: InputError, one line naming the file and the remedy: missing folder, json without
/// frames, frame listed but absent, unreadable or truncated PNG, zero-size image, size other than
/// stated, NaN in a pose, singular pose, times all equal (unless allowed), no training frames, a
/// window of a scene of one timestep or of more windows than its timesteps make.
Scene load_scene(const std::filesystem::path& folder, const SceneOptions& options);
/// Cameras, times, sizes, masks and points alone: no frame has pixels.
Scene scene_without_pixels(const std::filesystem::path& folder, bool allow_static,
                           const std::optional<Window>& window = {});

/// True when load_scene can read `folder` as it is: a prepared scene, or transforms files that list
/// PNGs without lens distortion.
bool opens_as_scene(const std::filesystem::path& folder);

}  // namespace tessera
