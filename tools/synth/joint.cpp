// What: a chain of joints evaluated at a timestep, from the solid to the root.
// Not: a motion of the solid's own (motion.cpp).
#include "tools/synth/joint.h"

#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

namespace tessera::synth {

double value_at(const Wave& wave, double time) {
  return wave.mean +
         wave.amplitude * std::sin(2 * std::numbers::pi * (wave.cycles * time + wave.phase));
}

Pose carried(const std::vector<Joint>& joints, const Pose& pose, double time) {
  Pose moved = pose;
  for (auto joint = joints.rbegin(); joint != joints.rend(); ++joint) {
    glm::dmat3 rotation(1.0);
    for (const Turn& each : joint->turns)
      rotation = turn(glm::radians(value_at(each.degrees, time)), each.axis) * rotation;
    moved.linear = rotation * moved.linear;
    moved.origin = joint->pivot + rotation * (moved.origin - joint->pivot) +
                   joint->direction * value_at(joint->shift, time);
  }
  return moved;
}

}  // namespace tessera::synth
