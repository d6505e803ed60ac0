// The pose of an object at a timestep: a path or a throw, a spin and a stretch about its rest pose.
// Shapes that bend are elsewhere (the cloth of shape.h); no physics but that of a throw.
#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace tessera::synth {

/// x_in_world = linear · x_in_object + origin.
struct Pose {
  glm::dmat3 linear{1.0};
  glm::dvec3 origin{0.0};
};

/// All cycles and turns are counted over the clip, t in [0, 1].
struct Motion {
  glm::dvec3 rest{0.0};           // world units
  glm::dmat3 rest_rotation{1.0};  // world from object; lengths of columns: sizes along its axes
  glm::dvec3 sway_sine{0.0};      // the path is rest + sway_sine·sin θ + sway_cosine·cos θ,
  glm::dvec3 sway_cosine{0.0};    // θ = 2π·sway_cycles·t: an ellipse, an arc or a line
  double sway_cycles = 1;
  glm::dvec3 spin_axis{0, 0, 1};  // in the world
  double spin_turns = 0;
  double stretch = 0;          // z grows by e^{s}, x and y by e^{-s/2}: the volume is kept;
  double stretch_cycles = 1;   // s = stretch · sin(2π·stretch_cycles·t)
  double stretch_base = 0;     // height below the object's origin that stays where it is
  glm::dvec3 launch{0.0};      // a throw: launch·τ + gravity·τ²/2, τ: time since `begin`
  glm::dvec3 gravity{0.0};     // metres per clip²
  double begin = -1, end = 2;  // normalised times before and after which it stands still
};

Pose pose_at(const Motion& motion, double time);

/// The rotation about `axis`, which may have any length.
glm::dmat3 turn(double radians, const glm::dvec3& axis);
/// Rotations by an angle in degrees about the world's z and x.
glm::dmat3 turn_z(double degrees);
glm::dmat3 turn_x(double degrees);

}  // namespace tessera::synth
