// More control points for motion nodes: the new spline follows the old one as closely as it can.
#pragma once
#include "recon4d/model/motion_nodes.h"

namespace tessera {

/// Control points `knots` whose spline is the old one in the least-squares sense, exactly where
/// knots = 2·S − 3. `knots` is at least as large as before. Optimizer state is zero afterwards.
/// `step`: steps done. Nodes are in any memory.
void refit_nodes(int knots, int64_t step, MotionNodes& nodes);

}  // namespace tessera
