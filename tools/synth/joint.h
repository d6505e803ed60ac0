// What: joints that carry a solid: turns about pivots by angles that swing, chained from a root.
// Not: limits, forces or skinning; what a joint carries stays rigid.
#pragma once
#include <glm/vec3.hpp>
#include <vector>

#include "tools/synth/motion.h"

namespace tessera::synth {

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
