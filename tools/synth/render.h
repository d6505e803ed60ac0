// What: images of a world by supersampled ray casting: the part that never changes once a camera,
//       then each timestep's movers over it.
// Not: sensor effects or 8-bit images (sensor.h).
#pragma once
#include <cstdint>
#include <vector>

#include "kernels/base/camera.h"
#include "tools/synth/ray_cast.h"

namespace tessera::synth {

struct RenderedImage {
  int width = 0, height = 0;
  std::vector<float> rgba;  // [height, width, 4] sRGB in [0, 1], alpha straight (not premultiplied)
  std::vector<uint8_t> mask;  // [height, width] 255 where a sample met something that changes, or 0
  std::vector<float> moving_share = {};  // [height, width] of the samples, that met such a thing
};

/// What a camera sees of the unchanging part; valid for the world and camera it was made with.
struct StaticLayer {
  int grid = 0;                   // samples per pixel: grid × grid, regular
  std::vector<float> depth;       // [height, width, grid²] camera z; infinite where nothing is
  std::vector<glm::vec3> colour;  // [height, width, grid²] 0 where nothing is
};

/// The ray through image point (x, y), pixels; depths along it are camera z.
Ray pixel_ray(const Camera& camera, double x, double y);

StaticLayer render_static(const World& world, const Camera& camera, int grid);
/// The whole image at `time` (normalised).
RenderedImage render(const World& world, const Camera& camera, double time,
                     const StaticLayer& layer);
/// Both steps, for a camera that is used once.
RenderedImage render(const World& world, const Camera& camera, double time, int grid);

}  // namespace tessera::synth
