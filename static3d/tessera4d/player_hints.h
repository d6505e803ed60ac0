// Data that a player needs besides Gaussians: the cameras of the rig, the upward direction, and the
// drawing rules of splats. All manifests hold them under the same keys. Source:
// docs/reference/tessera4d.md, section 3.
#pragma once
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "kernels/base/camera.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// A camera of the rig, to be looked through.
struct PlayerCamera {
  std::string name;
  Camera camera;  // in the world of the file
};

nlohmann::json camera_json(const PlayerCamera& rig);
/// {name, camera, t, image}: a frame that the player compares with the model; `image`: its address.
nlohmann::json truth_json(const Frame& frame, const std::string& image);
/// Dilation, cut-offs and clip planes.
nlohmann::json splat_json(const GaussianModel& rules);
/// Unit length: the mean direction against the cameras' down, or that of the axes (−y).
std::array<double, 3> up_of(const std::vector<PlayerCamera>& cameras);

}  // namespace tessera
