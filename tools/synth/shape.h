// The shapes of the world in their own space, and their intersections with rays.
#pragma once
#include <glm/vec3.hpp>

namespace tessera::synth {

enum class ShapeKind {
  kQuad,       // |x| <= half.x, |y| <= half.y, z = 0, both sides
  kBox,        // |x|, |y|, |z| <= half
  kSphere,     // radius half.x
  kCylinder,   // radius half.x about z, |z| <= half.z, with caps
  kRoundCone,  // balls of radius half.x at z = -half.z and half.y at z = +half.z, and their hull
  kCloth,      // |x| <= half.x, |y| <= half.y, z = cloth_height: pinned at y = +half.y
  kSkirt,      // |z| <= half.z, radius half.x at the top, about half.y at the bottom (skirt.h)
};

struct Shape {
  ShapeKind kind = ShapeKind::kSphere;
  glm::dvec3 half{1.0};    // half sizes, world units; cloth: half.z is the swing at the free edge
  double wave_cycles = 0;  // cloth, skirt: waves that pass over the clip
};

struct ShapeHit {
  double depth = 0;   // the ray's parameter
  glm::dvec3 point;   // object space
  glm::dvec3 normal;  // object space, not of unit length, towards the outside (quad, cloth: +z)
  int axis = 2;       // coordinate nearest to the normal
};

/// First meeting of origin + depth·direction with depth in (0, hit.depth); direction need not be
/// of unit length. True: `hit` is replaced. `time` moves only the cloth and the skirt.
bool intersect(const Shape& shape, const glm::dvec3& origin, const glm::dvec3& direction,
               double time, ShapeHit& hit);

/// Radius of a sphere about the shape's origin that holds it at all times.
double bounding_radius(const Shape& shape);

/// z of the cloth at (x, y).
double cloth_height(const Shape& shape, double x, double y, double time);

}  // namespace tessera::synth
