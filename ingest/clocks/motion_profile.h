// What: the offset of two clips from when and where they move, without any feature: coarse, but
//       over seconds.
// Not: sub-frame precision (motion_matches.h).
#pragma once
#include <optional>

#include "ingest/clocks/clip_motion.h"
#include "ingest/clocks/offset_solver.h"
#include "ingest/poses/rig_camera.h"

namespace tessera {

/// Correlates the clips' motion over time, separately on each plane through both camera centres,
/// which a point never seems to leave for one of the cameras only. `sigma` is a frame. Nothing
/// where no shift stands out.
std::optional<PairOffset> coarse_offset(const MotionEnergy& a, const MotionEnergy& b,
                                        const RigCamera& camera_a, const RigCamera& camera_b);

}  // namespace tessera
