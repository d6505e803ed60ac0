// Straight lines by least squares under the fade of each piece.
#include "static3d/line_motion/pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "static3d/line_motion/lines.h"

namespace tessera {
namespace {

constexpr int kCounts[] = {2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, kMaxPieces};
constexpr double kFade = 0.65;  // σ_t by the distance of pieces: their sum is even to 1 in 1,000

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
double strays(const Points& points, const LinePiece& piece, double reach, double longest) {
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

/// `count` pieces in the clip and one before and behind it; none where one strays by more than
/// `tolerance`.
std::vector<LinePiece> even_pieces(const Points& points, int count, double longest,
                                   double tolerance) {
  const double distance = 1 / double(count);
  std::vector<LinePiece> pieces;
  for (int i = -1; i <= count; ++i) {
    pieces.push_back(fitted(points, (i + 0.5) * distance, kFade * distance, 1.5 * distance));
    if (strays(points, pieces.back(), distance, longest) > tolerance) return {};
  }
  return pieces;
}

}  // namespace

std::vector<LinePiece> line_pieces(const Points& points, const Vec3<double>& scale) {
  const double longest = std::max({scale.x, scale.y, scale.z});
  const double shortest = std::min({scale.x, scale.y, scale.z});
  const double tolerance = scale.x + scale.y + scale.z - longest - shortest;  // the middle one
  const LinePiece one = fitted(points, 0.5, kLongLife, 1);
  if (strays(points, one, 1, longest) <= tolerance) return {one};
  for (const int count : kCounts)
    if (std::vector<LinePiece> pieces = even_pieces(points, count, longest, tolerance);
        !pieces.empty())
      return pieces;
  return even_pieces(points, kMaxPieces, longest, std::numeric_limits<double>::infinity());
}

double piece_opacity(double opacity) {
  // At one standard deviation: opaque at their middle, pieces would be too wide. Over a distance of
  // pieces, the mean of what they cover together.
  const double falloff = std::exp(-0.5);
  const auto together = [&](double each) {
    constexpr int kTimes = 8, kReach = 3;
    double sum = 0;
    for (int k = 0; k < kTimes; ++k) {
      double seen_through = 1;
      for (int i = -kReach; i <= kReach; ++i) {
        const double deviations = (i + (k + 0.5) / kTimes) / kFade;
        seen_through *= 1 - falloff * each * std::exp(-0.5 * deviations * deviations);
      }
      sum += 1 - seen_through;
    }
    return sum / kTimes;
  };
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (together(middle) < falloff * opacity ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace tessera
