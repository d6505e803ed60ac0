// What: a world placed at a timestep, the nearest thing a ray meets in it, and its lit colour.
// Not: images (render.h); a ray here is one sample.
#pragma once
#include <glm/glm.hpp>
#include <limits>
#include <vector>

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

}  // namespace tessera::synth
