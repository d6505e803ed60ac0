// A set of Gaussians on curves as lines (pieces.h).
#pragma once
#include <functional>

#include "recon4d/model/gaussian_set.h"
#include "static3d/line_motion/pieces.h"

namespace tessera {

struct CurveLines {
  GaussianSet lines;  // of the form kVelocity, in the order of the Gaussians
  int64_t bent = 0;   // Gaussians of which one line is not enough
  double strays = 0;  // of a piece, at most, by the middle scale of its Gaussian; 0: none is bent
};

/// Scales, opacity and SH are those of `shapes`; where a Gaussian is, is that of its curve, which
/// `curve_of` tells from several threads.
CurveLines lines_on_curves(const GaussianSet& shapes,
                           const std::function<Curve(int64_t)>& curve_of);

}  // namespace tessera
