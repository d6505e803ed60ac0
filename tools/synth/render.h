// Images of a world by supersampled ray casting: the static part once for a camera, then the moving
// solids of each timestep over it.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "kernels/base/camera.h"
#include "tools/synth/world.h"

namespace tessera::synth {

struct Ray {
  glm::dvec3 origin{0.0}, direction{0.0};  // direction may have any length; depth counts in it
};

/// A solid at a timestep, with what a ray needs computed once.
struct PlacedSolid {
  const Solid* solid = nullptr;
  double time = 0;
  glm::dmat3 object_from_world{1.0};  // of directions
  glm::dvec3 origin{0.0};             // of the object, world
  double radius = 0;                  // of a ball about origin that holds it, world units
};

/// What of the world is placed: what never changes, or what does.
enum class Part { kStatic, kMoving };

/// The solids of that part that exist at `time` (normalised). `world` must outlive the result.
std::vector<PlacedSolid> place(const World& world, Part part, double time);

struct Meeting {
  const PlacedSolid* placed = nullptr;  // null: the ray met nothing
  ShapeHit hit{std::numeric_limits<double>::infinity(), {}, {}, 2};
};

/// Replaces `meeting` when the ray meets `placed` nearer than meeting.hit.depth.
void cast(const Ray& ray, const PlacedSolid& placed, Meeting& meeting);
/// The nearest meeting with any of `solids`.
Meeting cast(const Ray& ray, const std::vector<PlacedSolid>& solids);

/// sRGB colour in [0, 1]. `casters` throw shadow where the solid receives it.
glm::vec3 shade(const Light& light, const Ray& ray, const Meeting& meeting,
                const std::vector<PlacedSolid>& casters);

/// Pixels [x0, x1) × [y0, y1); empty as it begins.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  /// Grows to hold `other`.
  void include(const PixelBox& other);
};

struct RenderedImage {
  int width = 0, height = 0;
  std::vector<float> rgba;  // [height, width, 4] sRGB in [0, 1], alpha straight (not premultiplied)
  std::vector<uint8_t> mask;  // [height, width] 255 where a sample met something that changes, or 0
  std::vector<float> moving_share = {};  // [height, width] of the samples, that met such a thing
  std::map<std::string, PixelBox> boxes = {};  // of the pixels that show each solid that changes
};

/// The image of the static part for one camera; valid for the world and camera it was made with.
struct StaticLayer {
  int grid = 0;                   // samples per pixel: grid × grid, regular
  std::vector<float> depth;       // [height, width, grid²] camera z; infinite where nothing is
  std::vector<glm::vec3> colour;  // [height, width, grid²] 0 where nothing is
};

/// The ray through image point (x, y), pixels; depths along it are camera z.
Ray pixel_ray(const Camera& camera, double x, double y);

StaticLayer render_static(const World& world, const Camera& camera, int grid);
/// The whole image at `time` (normalised), each row at its own where the camera has a readout.
RenderedImage render(const World& world, const Camera& camera, double time,
                     const StaticLayer& layer);
/// Both steps, for a camera that is used once.
RenderedImage render(const World& world, const Camera& camera, double time, int grid);

}  // namespace tessera::synth
