// The velocities of the moving points of a key timestep.
#pragma once
#include <cstdint>
#include <vector>

#include "ingest/cloud/plane_sweep.h"

namespace tessera {

struct VelocityCount {
  int64_t moving = 0;    // points that are not still
  int64_t reliable = 0;  // those of them whose velocity was found; the others keep 0
};

/// Sets SweptPoint::velocity, world units per unit of normalised time, of the moving points among
/// `points`, which share a timestep of `sweep`. The scenes of `around` hold the training frames of
/// the timesteps beside that one: of each camera the nearest frame before and the nearest after
/// count.
///
/// Each point's displacement in a timestep is searched from rest, at several levels of the pyramids
/// (PointMotion), and again from what its neighbours found; the one that differs least from the
/// images wins. It is reliable when three cameras or more agree with it, their
/// windows hold enough structure to tell it to half a pixel whatever its direction, and the images
/// differ clearly less than without motion, or it is less than half a pixel. A displacement above
/// three point spacings that the neighbours contradict is not. A reliable displacement becomes the
/// median of those of the neighbours that agree with it. A point without a reliable one takes what
/// its neighbours agree on, where that explains the images better than rest. The same for any
/// number of threads.
VelocityCount find_velocities(const PlaneSweep& sweep, const std::vector<const Scene*>& around,
                              const std::vector<SweptPoint*>& points);

}  // namespace tessera
