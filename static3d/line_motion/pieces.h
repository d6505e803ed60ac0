// A Gaussian on a curve as lines: one where a line is near enough, else pieces that follow each
// other at even distances, each of which fades while the next comes.
#pragma once
#include <vector>

#include "kernels/math/symmetric.h"
#include "static3d/line_motion/lines.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {

/// Where a Gaussian is at a time.
struct CarriedPoint {
  Vec3<double> mean;      // world units
  Vec4<double> rotation;  // unit quaternion w,x,y,z
};

/// The way of a Gaussian that fades about `centre` by exp(−½ ((t − centre) / extent)²).
struct Curve {
  std::vector<CarriedPoint> points;         // at even times of `time`, at least two
  Interval time{0, 1};                      // normalised
  double centre = 0.5, extent = kLongLife;  // μ_t and σ_t, normalised
};

/// A part of a curve as a line (lines.h).
struct LinePiece {
  double time, extent;          // μ_t and σ_t, normalised
  Vec3<double> mean, velocity;  // world units, and these per clip
  Vec4<double> rotation;        // unit quaternion w,x,y,z, through the piece
  double strays = 0;            // world units: how far from the curve, as far as the next piece
  bool is_part = false;         // of several, which together are the Gaussian
  double share = 1;             // of the Gaussian's opacity, there is at `time`
};

/// The second of three numbers by size.
double middle(const Vec3<double>& values);

/// `scale`: standard deviations along the axes, world units. The fewest lines, up to kMaxPieces in
/// the time of the curve, of which none strays from it by more than the middle scale, nor turns the
/// longest axis by more.
std::vector<LinePiece> line_pieces(const Curve& curve, const Vec3<double>& scale);
inline constexpr int kMaxPieces = 128;

/// What a part of the clip has of a line: all of one that is seen in it alone, and of one that is
/// seen beyond it, too, pieces that together fade at its ends, so that this and what follows it add
/// up. A part that begins or ends the clip has what lies beyond.
std::vector<LinePiece> pieces_within(const LinePiece& line, const Interval& part);

/// The opacity of each piece of several that together cover, at one standard deviation, what a
/// Gaussian of `opacity` does.
double piece_opacity(double opacity);

}  // namespace tessera
