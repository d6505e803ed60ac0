// What stands still in a whole clip, as a scene of one timestep: the background that all windows of
// a long clip share.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace tessera {

struct StaticSceneReport {
  int64_t cameras = 0;
  double shared = 0;  // share of all pixels that look the same all along
  std::vector<std::string> warnings;
};

/// Writes a prepared scene of one image for each camera of the prepared scene `folder`, held-out
/// cameras included: its CameraBackground, of up to 31 frames spread over each quarter of the clip.
/// Its mask ignores pixels where there is none (what moves on one spot, was moved, or whose light
/// has changed), and what the masks of the scene ignore. Points are those of the scene that stand
/// still and that an image shows. `progress` is told the cameras done and all of them. Errors:
/// InputError: no prepared scene, images with alpha, a camera that moves, less than three frames a
/// quarter; as load_scene.
StaticSceneReport write_static_scene(const std::filesystem::path& folder,
                                     const std::filesystem::path& out,
                                     const std::function<void(int64_t, int64_t)>& progress);

}  // namespace tessera
