// How near to its cameras the content of a scene comes, by its point cloud: between the cameras and
// that depth nothing needs to be drawn. Gaussians that stand there show in no training image, but
// cover the view of a camera that is held out.
#pragma once
#include <optional>

#include "ingest/scene.h"

namespace tessera {

/// Smallest depth, world units along the viewing axis, at which a training camera sees points of
/// `scene.points`. Of each camera, in its first frame, the nearest five hundredth of the points
/// that it sees are left out: matches between images are wrong now and then, and then are often
/// near. None where no camera sees 500 points.
std::optional<double> nearest_depth(const Scene& scene);

}  // namespace tessera
