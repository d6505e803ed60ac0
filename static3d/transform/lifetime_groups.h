// Dynamic Gaussians as groups that appear, move at one velocity and disappear together, for formats
// that show and hide whole meshes. A Gaussian is visible where its marginal in time exceeds 1/2.
// Source: kernels/math/spacetime.h.
#pragma once
#include <vector>

#include "static3d/transform/slicer.h"

namespace tessera {

struct LifetimeGroup {
  std::vector<int64_t> members;  // indices of Slicer::moving()
  double begin = 0, end = 1;     // normalised time: mean of the members' visible intervals
  double mean_time = 0;          // where the frame of the group is that of the world
  Vec3<double> velocity{};       // world units per unit of normalised time
};

struct LifetimeGroups {
  std::vector<int64_t> fixed;         // visible all the time, at rest
  std::vector<int64_t> never_drawn;   // visible at no time of the clip
  std::vector<LifetimeGroup> groups;  // by begin
  double rms_error = 0;               // world units, by velocities alone, while visible
};

/// `extent`: of the scene, world units. Groups are the entries of a palette of mean times, extents
/// in time and displacements.
LifetimeGroups lifetime_groups(const std::vector<MovingGaussian>& moving, double time_filter,
                               double extent, int64_t most = 256);

}  // namespace tessera
