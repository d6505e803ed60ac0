// A Gaussian on a curve as lines: one where a line is near enough, else pieces that follow each
// other at even distances, each of which fades while the next comes.
#pragma once
#include <vector>

#include "kernels/math/symmetric.h"

namespace tessera {

/// Where a Gaussian is at a time.
struct CarriedPoint {
  Vec3<double> mean;      // world units
  Vec4<double> rotation;  // unit quaternion w,x,y,z
};

/// A part of a curve as a line (lines.h).
struct LinePiece {
  double time, extent;          // μ_t and σ_t, normalised
  Vec3<double> mean, velocity;  // world units, and these per clip
  Vec4<double> rotation;        // unit quaternion w,x,y,z, through the piece
};

/// `points`: at even times from 0 to 1, at least two; `scale`: standard deviations along the axes,
/// world units. The fewest lines, up to kMaxPieces in the clip, of which none strays from the curve
/// by more than the middle scale, as far as the next piece, nor turns the longest axis by more.
std::vector<LinePiece> line_pieces(const std::vector<CarriedPoint>& points,
                                   const Vec3<double>& scale);
inline constexpr int kMaxPieces = 128;

/// The opacity of each piece of several that together cover, at one standard deviation, what a
/// Gaussian of `opacity` does.
double piece_opacity(double opacity);

}  // namespace tessera
