// A set of lines from pieces (pieces.h).
#pragma once
#include <functional>

#include "recon4d/model/gaussian_set.h"
#include "static3d/line_motion/pieces.h"

namespace tessera {

struct PieceLines {
  GaussianSet lines;  // of the form kVelocity, in the order of the Gaussians
  int64_t bent = 0;   // Gaussians of several lines
  double strays = 0;  // of a piece, at most, by the middle scale of its Gaussian; 0: none is bent
};

/// Scales, opacity and SH are those of `shapes`; when and where a Gaussian is, its pieces say,
/// which `pieces_of` tells from several threads.
PieceLines lines_of_pieces(const GaussianSet& shapes,
                           const std::function<std::vector<LinePiece>(int64_t)>& pieces_of);

/// A Gaussian of a set of lines.
LinePiece line_at(const GaussianSpans<const float>& lines, int64_t n);
/// Standard deviations of Gaussian n along its axes, world units.
Vec3<double> scale_of(const GaussianSpans<const float>& set, int64_t n);

}  // namespace tessera
