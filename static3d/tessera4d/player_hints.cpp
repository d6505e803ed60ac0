// The keys and values of the hints in manifests.
#include "static3d/tessera4d/player_hints.h"

#include <nlohmann/json.hpp>

#include "kernels/math/eigen3.h"
#include "kernels/math/ewa.h"
#include "kernels/math/splat.h"

namespace tessera {

nlohmann::json camera_json(const PlayerCamera& rig) {
  const Camera& camera = rig.camera;
  const glm::dvec3 position = camera.position();
  const glm::dmat3 turn = glm::transpose(camera.cam_from_world);
  const Vec4<double> q = quaternion_from_rotation(turn);
  return {{"name", rig.name},
          {"position", {position.x, position.y, position.z}},
          {"rotation", {q[0], q[1], q[2], q[3]}},
          {"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fl_x},
          {"fy", camera.fl_y},
          {"cx", camera.cx},
          {"cy", camera.cy}};
}

nlohmann::json truth_json(const Frame& frame, const std::string& image) {
  return {{"name", frame.name},
          {"camera", camera_json({frame.name, frame.camera})},
          {"t", frame.time},
          {"image", image}};
}

nlohmann::json splat_json(const GaussianModel& rules) {
  const Cutoff<double> cutoff = rules.cutoff<double>();
  return {{"dilation", rules.drawing.filter_2d ? kFilter2d<double> : kDilation<double>},
          {"compensated", rules.drawing.filter_2d},
          {"cutoff_sigma", rules.drawing.truncation_sigma},
          {"cutoff_alpha", cutoff.least_alpha},
          {"cutoff_falloff", cutoff.least_falloff},
          {"near", rules.drawing.near_plane},
          {"far", rules.drawing.far_plane}};
}

std::array<double, 3> up_of(const std::vector<PlayerCamera>& cameras) {
  glm::dvec3 up{0, 0, 0};
  for (const PlayerCamera& rig : cameras)
    up -= glm::transpose(rig.camera.cam_from_world) * glm::dvec3(0, 1, 0);
  const double length = glm::length(up);
  if (!(length > 1e-3 * double(cameras.size()))) return {0, -1, 0};
  return {up.x / length, up.y / length, up.z / length};
}

}  // namespace tessera
