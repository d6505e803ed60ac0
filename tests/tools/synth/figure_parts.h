// The parts of the figure by name, the positions of their ends, and the times at which it is
// defined.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tools/synth/world.h"

namespace tessera::synth {

inline const Solid& part(const World& world, const std::string& name) {
  const auto found = std::find_if(world.solids.begin(), world.solids.end(),
                                  [&](const Solid& solid) { return solid.name == name; });
  EXPECT_NE(found, world.solids.end()) << name;
  return *found;
}

inline Pose pose_of(const Solid& solid, double time) {
  return carried(solid.joints, pose_at(solid.motion, time), time);
}

/// The middle of the ball at the upper (+1) or lower (-1) end of a limb.
inline glm::dvec3 end_of(const Solid& limb, int end, double time) {
  const Pose pose = pose_of(limb, time);
  return pose.linear * glm::dvec3(0, 0, end * limb.shape.half.z) + pose.origin;
}

/// Times of the clip and of a clip's length before and after.
inline std::vector<double> many_times() {
  std::vector<double> times;
  for (int i = -60; i < 120; ++i) times.push_back(i / 60.0);
  return times;
}

}  // namespace tessera::synth
