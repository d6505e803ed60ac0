// The list of a scene's frames, with its points: what is known of it before any image is read.
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "ingest/clocks/windows.h"
#include "ingest/prepared/transforms_json.h"
#include "ingest/scene.h"

namespace tessera {

struct ListedScene {
  TransformsCapture capture;      // in the world of the scene
  std::vector<double> time;       // [frame] normalised
  std::vector<int64_t> timestep;  // [frame] Frame::timestep
  Scene scene;                    // without frames

  /// Leaves the frames of a window, as a clip of their own. Errors: InputError: one timestep, or
  /// less than two a window.
  void cut(const Window& window);
};

/// Errors: those of load_scene that come before its images.
ListedScene list_scene(const std::filesystem::path& folder, bool allow_static);

}  // namespace tessera
