// Checks of the initial cloud: whether it exists, lies where the cameras look and has the colours
// of the images; and the smallest depth at which the cameras see it.
#pragma once
#include <optional>

#include "ingest/checks/finding.h"
#include "ingest/scene.h"

namespace tessera {

struct CloudHealth {
  int64_t points = 0, not_finite = 0, duplicates = 0;
  int64_t far = 0;           // outside of ten times the box of cameras and their view
  int64_t unseen = 0;        // in the image of no training camera
  int64_t seen_by_one = 0;   // in the image of exactly one
  double colour_ratio = -1;  // median colour difference of a point to the images by that of
                             // another point's colour: about 0 right, 1 chance; −1: not measured
  Findings findings;
};

/// Needs pixels. Points with a timestep are compared like the others: against the median image.
CloudHealth check_cloud(const Scene& scene);

/// Smallest depth, world units along the viewing axis, at which a training camera sees points of
/// `scene.points`. Of each camera, in its first frame, the nearest five hundredth of the points
/// that it sees are left out: matches between images are wrong now and then, and then are often
/// near. None where no camera sees 500 points.
std::optional<double> nearest_depth(const Scene& scene);

}  // namespace tessera
