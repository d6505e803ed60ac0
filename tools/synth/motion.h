// The pose of an object at a timestep: a path or a throw, a spin and a stretch about its rest pose,
// and the joints that carry it. Apart from the throw, no physics is simulated.
#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

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

/// mean + amplitude · sin(2π (cycles·t + phase)), t in [0, 1] over the clip.
struct Wave {
  double mean = 0, amplitude = 0;
  double cycles = 1, phase = 0;
};
double value_at(const Wave& wave, double time);

struct Turn {
  glm::dvec3 axis{0, 0, 1};
  Wave degrees;
};

/// Pivot, axes and direction are those of the rest pose, in which no joint turns or shifts.
struct Joint {
  glm::dvec3 pivot{0.0};
  std::vector<Turn> turns;    // about the pivot, the first one first
  glm::dvec3 direction{0.0};  // after the turns everything moves by direction · shift
  Wave shift;
};

/// Where a solid that stands at `pose` in the rest pose is at `time`. The first of `joints` is the
/// root; each carries those after it, so the last one is nearest to the solid.
Pose carried(const std::vector<Joint>& joints, const Pose& pose, double time);

}  // namespace tessera::synth
