// Eight cameras in two rows before two textured planes, rendered exactly by ray casting. Every
// camera has one timestep.
#pragma once
#include <cmath>
#include <glm/glm.hpp>
#include <string>

#include "ingest/scene.h"

namespace tessera::testing {

/// Rodrigues' formula.
inline glm::dmat3 rotation_about(const glm::dvec3& axis, double angle) {
  const glm::dmat3 cross{0, axis.z, -axis.y, -axis.z, 0, axis.x, axis.y, -axis.x, 0};
  return glm::dmat3(1.0) + std::sin(angle) * cross + (1 - std::cos(angle)) * (cross * cross);
}

/// Value noise in [0, 1], smooth between cells of unit size.
inline double value_noise(double x, double y, uint32_t seed) {
  const auto corner = [seed](int64_t i, int64_t j) {
    uint32_t h = seed ^ uint32_t(i * 73856093) ^ uint32_t(j * 19349663);
    h = (h ^ (h >> 16)) * 0x45d9f3bu;
    h = (h ^ (h >> 16)) * 0x45d9f3bu;
    return double((h ^ (h >> 16)) & 0xffff) / 65535;
  };
  const double u = x - std::floor(x), v = y - std::floor(y);
  const auto i = int64_t(std::floor(x)), j = int64_t(std::floor(y));
  const double su = u * u * (3 - 2 * u), sv = v * v * (3 - 2 * v);
  return (corner(i, j) * (1 - su) + corner(i + 1, j) * su) * (1 - sv) +
         (corner(i, j + 1) * (1 - su) + corner(i + 1, j + 1) * su) * sv;
}

/// A wall at z = 6 and, where x > 0.3, a nearer one at z = 4; +z is the viewing direction.
inline Scene textured_rig() {
  constexpr int kWidth = 240, kHeight = 180;
  Scene scene;
  scene.path = "textured rig";
  scene.is_static = true;
  for (int c = 0; c < 8; ++c) {
    Frame frame;
    frame.camera_name = "cam" + std::to_string(c);
    frame.name = frame.camera_name + "/0";
    Camera& camera = frame.camera;
    camera.width = kWidth;
    camera.height = kHeight;
    camera.fl_x = camera.fl_y = 260;
    camera.cx = kWidth / 2.0;
    camera.cy = kHeight / 2.0;
    const glm::dvec3 eye{0.35 * (c % 4) - 0.5, 0.4 * (c / 4) - 0.2, 0.1 * (c % 3)};
    camera.cam_from_world = rotation_about({0, 1, 0}, 0.05 * (c % 4) - 0.08);
    camera.translation = -(camera.cam_from_world * eye);
    frame.image = {kWidth, kHeight, 3, {}};
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const glm::dvec3 ray =
            glm::transpose(camera.cam_from_world) *
            glm::dvec3{(x + 0.5 - camera.cx) / camera.fl_x, (y + 0.5 - camera.cy) / camera.fl_y, 1};
        glm::dvec3 p = eye + ray * ((4 - eye.z) / ray.z);
        const bool near_wall = p.x > 0.3;
        if (!near_wall) p = eye + ray * ((6 - eye.z) / ray.z);
        for (uint32_t k = 0; k < 3; ++k) {
          const double value = 0.4 * value_noise(6 * p.x, 6 * p.y, 1 + near_wall) +
                               0.35 * value_noise(20 * p.x, 20 * p.y, 3) +
                               0.25 * value_noise(5 * p.x, 5 * p.y, 10 + k);
          frame.image.data.push_back(uint8_t(20 + 180 * value));
        }
      }
    scene.frames.push_back(std::move(frame));
  }
  return scene;
}

}  // namespace tessera::testing
