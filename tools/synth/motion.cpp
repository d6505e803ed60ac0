// Evaluates a motion at a timestep. There are no derivatives; ground truth needs positions only.
#include "tools/synth/motion.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

namespace tessera::synth {

glm::dmat3 turn(double radians, const glm::dvec3& axis) {
  return glm::mat3_cast(glm::angleAxis(radians, glm::normalize(axis)));
}
glm::dmat3 turn_z(double degrees) {
  return turn(glm::radians(degrees), {0, 0, 1});
}
glm::dmat3 turn_x(double degrees) {
  return turn(glm::radians(degrees), {1, 0, 0});
}

Pose pose_at(const Motion& motion, double time) {
  const double circle = 2 * std::numbers::pi;
  const double moved = std::clamp(time, motion.begin, motion.end), thrown = moved - motion.begin;
  const double theta = circle * motion.sway_cycles * moved;
  const double s = motion.stretch * std::sin(circle * motion.stretch_cycles * moved);
  const double tall = std::exp(s), wide = std::exp(-0.5 * s);
  const glm::dmat3 scale(wide, 0, 0, 0, wide, 0, 0, 0, tall);
  const glm::dmat3 spin = turn(circle * motion.spin_turns * moved, motion.spin_axis);
  Pose pose;
  pose.linear = spin * motion.rest_rotation * scale;
  pose.origin = motion.rest + motion.sway_sine * std::sin(theta) +
                motion.sway_cosine * std::cos(theta) + motion.launch * thrown +
                0.5 * motion.gravity * thrown * thrown +
                glm::dvec3(0, 0, motion.stretch_base * (tall - 1));
  return pose;
}

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
