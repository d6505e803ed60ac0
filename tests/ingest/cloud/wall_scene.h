// A textured wall of known depth seen by a row of cameras; part of the wall moves with time.
#pragma once
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "ingest/scene.h"

namespace tessera::testing {

inline constexpr double kWallDepth = 3;    // z of the wall, world units
inline constexpr double kWallMoves = 0.3;  // the pattern moves right of this x

/// Colour of the wall: waves of several lengths, so that no two places look the same.
inline std::array<uint8_t, 3> wall_colour(double x, double y, double time) {
  if (x > kWallMoves) x += time;
  std::array<uint8_t, 3> rgb;
  for (size_t c = 0; c < 3; ++c) {
    const double phase = double(c) * 1.7;
    const double wave = std::sin(9 * x + 4 * y + phase) + std::sin(23 * y - 7 * x + 2 * phase) +
                        std::sin(31 * x + 17 * y - phase);
    rgb[c] = uint8_t(127.5 + 40 * wave);
  }
  return rgb;
}

struct WallRig {
  int cameras = 5, timesteps = 2, size = 96;  // images are size × size
  double focus = 2.5;                         // z of what all cameras look at
  double apart = 0;    // frames that each camera films after the one before it
  double retreat = 0;  // of the whole wall over the clip, world units
  std::array<uint8_t, 3> (*colour)(int camera, double x, double y, double time) =
      [](int, double x, double y, double time) { return wall_colour(x, y, time); };
};

/// Cameras at x = −0.4 … 0.4, z = 0, that look at (0, 0, focus); timesteps from 0 to 1. All
/// training.
inline Scene wall_scene(const WallRig& rig = {}) {
  Scene scene;
  for (int k = 0; k < rig.cameras; ++k) {
    const double x = rig.cameras > 1 ? -0.4 + 0.8 * k / (rig.cameras - 1) : 0;
    const glm::dvec3 eye(x, 0, 0), forward = glm::normalize(glm::dvec3(-x, 0, rig.focus));
    const glm::dvec3 down(0, 1, 0), right = glm::cross(down, forward);
    for (int m = 0; m < rig.timesteps; ++m) {
      Frame frame;
      frame.camera.width = frame.camera.height = rig.size;
      frame.camera.fl_x = frame.camera.fl_y = rig.size;
      frame.camera.cx = frame.camera.cy = rig.size / 2.0;
      for (int i = 0; i < 3; ++i) frame.camera.cam_from_world[i] = {right[i], down[i], forward[i]};
      frame.camera.translation = -(frame.camera.cam_from_world * eye);
      frame.camera_name = "cam" + std::to_string(k);
      frame.name = frame.camera_name + "/" + std::to_string(m);
      frame.frame_number = m;
      frame.time = rig.timesteps > 1 ? double(m) / (rig.timesteps - 1) : 0;
      if (rig.apart != 0)
        frame.time = (m + 1 + rig.apart * (k - 0.5 * (rig.cameras - 1))) / (rig.timesteps + 1);
      frame.timestep = m;
      frame.image = {rig.size, rig.size, 3, {}};
      for (int v = 0; v < rig.size; ++v)
        for (int u = 0; u < rig.size; ++u) {
          const glm::dvec3 ray = forward + (u + 0.5 - rig.size / 2.0) / rig.size * right +
                                 (v + 0.5 - rig.size / 2.0) / rig.size * down;
          const glm::dvec3 p = eye + ray * ((kWallDepth + rig.retreat * frame.time) / ray.z);
          for (uint8_t level : rig.colour(k, p.x, p.y, frame.time))
            frame.image.data.push_back(level);
        }
      scene.frames.push_back(std::move(frame));
    }
  }
  return scene;
}

}  // namespace tessera::testing
