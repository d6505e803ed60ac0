// What: whether the initial cloud is there, lies where the cameras look, and has their colours.
// Not: its repair.
#pragma once
#include "ingest/checks/finding.h"
#include "ingest/scene.h"

namespace tessera {

struct CloudHealth {
  int64_t points = 0, not_finite = 0, duplicates = 0;
  int64_t far = 0;           // outside of ten times the box of cameras and their view
  int64_t unseen = 0;        // in the image of no training camera
  int64_t seen_by_one = 0;   // in that of one alone
  double colour_ratio = -1;  // median colour difference of a point to the images by that of
                             // another point's colour: about 0 right, 1 chance; −1: not measured
  Findings findings;
};

/// Needs pixels. Points with a timestep are compared like the others: against the median image.
CloudHealth check_cloud(const Scene& scene);

}  // namespace tessera
