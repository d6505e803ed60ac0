// Scenes of a known ring of cameras, and point clouds drawn into their images.
#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "ingest/checks/stations.h"
#include "ingest/files/png.h"
#include "ingest/scene.h"

namespace tessera::testing {

struct RingScene {
  int cameras = 6, timesteps = 3, size = 32;
};

/// Cameras cam0 … on a circle of radius 4 around the origin, all looking at it; all train.
inline Scene ring_scene(const RingScene& ring) {
  Scene scene;
  scene.path = "ring";
  scene.is_static = ring.timesteps == 1;
  for (int c = 0; c < ring.cameras; ++c)
    for (int m = 0; m < ring.timesteps; ++m) {
      const double angle = 2 * 3.14159265358979 * c / ring.cameras;
      const glm::dvec3 eye{4 * std::cos(angle), 0, 4 * std::sin(angle)};
      const glm::dvec3 ahead = -eye / 4.0, down{0, 1, 0}, right = glm::cross(down, ahead);
      Frame frame;
      frame.camera_name = "cam" + std::to_string(c);
      frame.name = frame.camera_name + "/" + std::to_string(m);
      frame.frame_number = m;
      frame.time = ring.timesteps == 1 ? 0 : double(m) / (ring.timesteps - 1);
      frame.timestep = m;
      Camera& camera = frame.camera;
      camera.width = camera.height = ring.size;
      camera.fl_x = camera.fl_y = ring.size;
      camera.cx = camera.cy = ring.size / 2.0;
      camera.cam_from_world = glm::transpose(glm::dmat3(right, down, ahead));
      camera.translation = -(camera.cam_from_world * eye);
      frame.image = {ring.size, ring.size, 3,
                     std::vector<uint8_t>(size_t(ring.size) * size_t(ring.size) * 3,
                                          uint8_t(20 + 10 * c + m))};
      scene.frames.push_back(std::move(frame));
    }
  return scene;
}

/// Points on a unit sphere (golden spiral), coloured by smooth functions of their place.
inline PointCloud coloured_sphere(int count) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - z * z), a = 2.39996323 * i;
    const glm::dvec3 p{r * std::cos(a), r * std::sin(a), z};
    cloud.position.push_back(glm::vec3(p));
    cloud.colour.push_back(
        {uint8_t(128 + 90 * p.x), uint8_t(128 + 90 * p.y), uint8_t(128 + 90 * p.z)});
  }
  return cloud;
}

/// Paints each point as 5 × 5 pixels, far ones first.
inline void paint_points(Scene& scene) {
  for (Frame& frame : scene.frames) {
    std::vector<std::pair<double, size_t>> order;
    for (size_t i = 0; i < scene.points.position.size(); ++i) {
      const glm::dvec3 p(scene.points.position[i]);
      order.push_back({-(frame.camera.cam_from_world * p + frame.camera.translation).z, i});
    }
    std::sort(order.begin(), order.end());
    for (const auto& [depth, i] : order) {
      double x = 0, y = 0;
      if (!project_into(frame.camera, glm::dvec3(scene.points.position[i]), x, y)) continue;
      for (int v = int(y) - 2; v <= int(y) + 2; ++v)
        for (int u = int(x) - 2; u <= int(x) + 2; ++u)
          if (u >= 0 && v >= 0 && u < frame.image.width && v < frame.image.height)
            std::copy_n(scene.points.colour[i].begin(), 3,
                        frame.image.data.begin() + 3 * (v * frame.image.width + u));
    }
  }
}

inline std::vector<std::filesystem::path> write_images(const Scene& scene,
                                                       const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    files.push_back(folder / (std::to_string(i) + ".png"));
    write_png(files.back(), scene.frames[i].image);
  }
  return files;
}

}  // namespace tessera::testing
