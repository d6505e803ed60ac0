// Straight lines by least squares under the fade of each piece.
#include "static3d/line_motion/pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tessera {
namespace {

constexpr int kCounts[] = {2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, kMaxPieces};
constexpr double kFade = 0.65;  // σ_t by the distance of pieces: their sum is even to 1 in 1,000
constexpr double kSeenOfLife = 2.5;  // deviations: 4 % of the opacity are left
constexpr double kLeastShare = 0.01;
constexpr int kTiles = 4;                     // pieces of a part of the clip
constexpr double kSide = 0.6065306597126334;  // of a splat's middle, at one standard deviation
constexpr int kOpacities = 1024;              // of a table
constexpr double kLeastOpacity = 1e-6;
constexpr double kMostOfLife = 0.5;  // of the Gaussian's σ_t, that of its pieces

using Points = std::vector<CarriedPoint>;

/// Times of the points that a piece at `time` has, as a range of indices: within `reach` of it, and
/// at least two.
std::pair<size_t, size_t> points_near(size_t count, double time, double reach) {
  const double last = double(count - 1);
  const double low = std::clamp(std::floor((time - reach) * last), 0.0, last - 1);
  const double high = std::clamp(std::ceil((time + reach) * last), low + 1, last);
  return {size_t(low), size_t(high) + 1};
}

/// Rotation between two points of a curve, at a time of [0, 1].
Vec4<double> rotation_at(const Points& points, double time) {
  const double place = std::clamp(time, 0.0, 1.0) * double(points.size() - 1);
  const size_t i = std::min(size_t(place), points.size() - 2);
  const Vec4<double>&a = points[i].rotation, b = points[i + 1].rotation;
  const double share = place - double(i);
  return glm::normalize(a * (1 - share) + b * (dot(a, b) < 0 ? -share : share));
}

LinePiece fitted(const Points& points, double time, double extent, double reach) {
  const auto [begin, end] = points_near(points.size(), time, reach);
  const double step = 1 / double(points.size() - 1);
  double weights = 0, centre = 0, spread = 0;
  Vec3<double> mean(0), slope(0);
  const auto weight_at = [&](double dt) { return std::exp(-0.5 * dt * dt / (extent * extent)); };
  for (size_t i = begin; i < end; ++i) {
    const double dt = double(i) * step - time, weight = weight_at(dt);
    weights += weight;
    centre += weight * dt;
    mean += points[i].mean * weight;
  }
  centre /= weights;
  mean /= weights;
  for (size_t i = begin; i < end; ++i) {
    const double dt = double(i) * step - time, weight = weight_at(dt);
    spread += weight * (dt - centre) * (dt - centre);
    slope += (points[i].mean - mean) * (weight * (dt - centre));
  }
  const Vec3<double> velocity = slope / spread;
  return {time, extent, mean - velocity * centre, velocity, rotation_at(points, time)};
}

/// The larger of how far the line strays and how far the end of the longest axis turns.
double strays_by(const Points& points, const LinePiece& piece, double reach, double longest) {
  const auto [begin, end] = points_near(points.size(), piece.time, reach);
  const double step = 1 / double(points.size() - 1);
  double most = 0;
  for (size_t i = begin; i < end; ++i) {
    const double dt = double(i) * step - piece.time;
    const double turn = std::min(1.0, std::abs(dot(points[i].rotation, piece.rotation)));
    most = std::max({most, glm::length(points[i].mean - (piece.mean + piece.velocity * dt)),
                     2 * longest * std::sqrt(1 - turn * turn)});
  }
  return most;
}

/// `count` pieces in the time of the curve and one before and behind it; none where one strays by
/// more than `tolerance`.
std::vector<LinePiece> even_pieces(const Points& points, int count, double longest,
                                   double tolerance) {
  const double distance = 1 / double(count);
  std::vector<LinePiece> pieces;
  for (int i = -1; i <= count; ++i) {
    LinePiece piece = fitted(points, (i + 0.5) * distance, kFade * distance, 1.5 * distance);
    piece.strays = strays_by(points, piece, distance, longest);
    if (piece.strays > tolerance) return {};
    pieces.push_back(piece);
  }
  return pieces;
}

/// What many pieces of that opacity cover at one standard deviation, the mean over a distance of
/// pieces. There and not at their middle: opaque there, they would be too wide.
double covered_together(double each) {
  constexpr int kTimes = 8, kReach = 3;
  double sum = 0;
  for (int k = 0; k < kTimes; ++k) {
    double seen_through = 1;
    for (int i = -kReach; i <= kReach; ++i) {
      const double deviations = (i + (k + 0.5) / kTimes) / kFade;
      seen_through *= 1 - kSide * each * std::exp(-0.5 * deviations * deviations);
    }
    sum += 1 - seen_through;
  }
  return sum / kTimes;
}

/// What a life leaves of a piece of it: pieces of σ under a life of σ' make one of √(σ² + σ'²),
/// which is 1 at its centre.
void give_share(double centre, double extent, LinePiece& piece) {
  const double life = std::sqrt(extent * extent - piece.extent * piece.extent);
  const double deviations = (piece.time - centre) / life;
  piece.share = std::exp(-0.5 * deviations * deviations) * extent / life;
  piece.is_part = true;
}

/// From times of [0, 1] to those of the curve.
std::vector<LinePiece> placed(const Curve& curve, std::vector<LinePiece> pieces) {
  const double length = curve.time.high - curve.time.low;
  for (LinePiece& piece : pieces) {
    piece.time = curve.time.low + length * piece.time;
    piece.extent *= length;
    piece.velocity /= length;
    if (pieces.size() > 1) give_share(curve.centre, curve.extent, piece);
  }
  return pieces;
}

}  // namespace

double middle(const Vec3<double>& values) {
  return std::max(std::min(values.x, values.y), std::min(std::max(values.x, values.y), values.z));
}

std::vector<LinePiece> line_pieces(const Curve& curve, const Vec3<double>& scale) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const Points& points = curve.points;
  const double longest = std::max({scale.x, scale.y, scale.z});
  const double tolerance = middle(scale);
  const double length = curve.time.high - curve.time.low;
  LinePiece one =
      fitted(points, (curve.centre - curve.time.low) / length, curve.extent / length, kAll);
  one.strays = strays_by(points, one, kAll, longest);
  const bool has_place = std::isfinite(glm::dot(one.mean, one.mean));
  if (!has_place || one.strays <= tolerance) return placed(curve, {one});
  for (const int count : kCounts)
    if (kFade * length <= kMostOfLife * curve.extent * count)
      if (std::vector<LinePiece> pieces = even_pieces(points, count, longest, tolerance);
          !pieces.empty())
        return placed(curve, std::move(pieces));
  return placed(curve, even_pieces(points, kMaxPieces, longest, kAll));
}

std::vector<LinePiece> pieces_within(const LinePiece& line, const Interval& part) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const Interval kept{part.low > 0 ? part.low : -kAll, part.high < 1 ? part.high : kAll};
  const double reach = kSeenOfLife * line.extent;
  if (line.time + reach < kept.low || line.time - reach >= kept.high) return {};
  const double distance = (part.high - part.low) / kTiles;
  const bool fits = line.time - reach >= kept.low && line.time + reach < kept.high;
  if (fits || kFade * distance > kMostOfLife * line.extent)
    return line.time >= kept.low && line.time < kept.high ? std::vector{line}
                                                          : std::vector<LinePiece>();
  std::vector<LinePiece> pieces;
  for (int i = part.low > 0 ? 0 : -1; i < kTiles + (part.high < 1 ? 0 : 1); ++i) {
    LinePiece piece = line;
    piece.time = part.low + (i + 0.5) * distance;
    piece.extent = kFade * distance;
    piece.mean += line.velocity * (piece.time - line.time);
    give_share(line.time, line.extent, piece);
    if (piece.share > kLeastShare) pieces.push_back(piece);
  }
  return pieces;
}

double piece_opacity(double opacity) {
  // Of pieces that are as opaque as the index says, by how opaque they are together.
  static const std::vector<double> table = [] {
    std::vector<double> covered;
    for (int i = 0; i <= kOpacities; ++i)
      covered.push_back(covered_together(double(i) / kOpacities) / kSide);
    return covered;
  }();
  const auto above = std::upper_bound(table.begin() + 1, table.end() - 1, opacity);
  const double low = *(above - 1), high = *above;
  const double place = double(above - table.begin() - 1) + (opacity - low) / (high - low);
  return std::clamp(place / kOpacities, kLeastOpacity, 1 - kLeastOpacity);
}

}  // namespace tessera
