// What stands still in a whole clip, as a scene of one timestep: the background that all windows of
// a long clip share. Each image is a median over time.
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
/// cameras included. Four medians are taken, each of up to 31 frames spread over a quarter of the
/// clip. A pixel whose four medians differ by more than 10 of 255 in a channel, and by more than
/// noise, shows something that was moved or whose light has changed, and one that is as in these
/// medians in less than 0.6 of the frames something that moves on one spot: its mask ignores both,
/// as it does what the masks of the scene ignore. Points are those of the scene that stand still
/// and that an image shows. `progress` is told the cameras done and all of them. Errors:
/// InputError: no prepared scene, images with alpha, a camera that moves, less than three frames a
/// quarter; as load_scene.
StaticSceneReport write_static_scene(const std::filesystem::path& folder,
                                     const std::filesystem::path& out,
                                     const std::function<void(int64_t, int64_t)>& progress);

}  // namespace tessera
