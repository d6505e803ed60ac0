// The surface of the skirt, and its intersection with a ray by steps that are small enough for its
// steepest fold.
#include "tools/synth/skirt.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>

namespace tessera::synth {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kFold = 0.07;   // height of the eight folds at the hem, of the hem's radius
constexpr double kPush = 0.14;   // largest push of a leg at the hem, of the hem's radius
constexpr double kSlope = 1.8;   // at least the largest change of gap() by distance near the cloth
constexpr double kCurve = 0.3;   // the cloth bulges: it flares most below the waist
constexpr double kStep = 0.003;  // shortest step along a ray, of the hem's radius

/// The angle of a unit vector doubled.
dvec2 doubled(const dvec2& v) {
  return {v.x * v.x - v.y * v.y, 2 * v.x * v.y};
}

}  // namespace

double skirt_reach(const Shape& shape) {
  return shape.half.y * (1 + kFold + kPush);
}

Skirt::Skirt(const Shape& shape, double time) : shape_(shape) {
  const double phase = 2 * std::numbers::pi * shape.wave_cycles * time;
  fold_sine_ = std::sin(phase);
  fold_cosine_ = std::cos(phase);
  push_ = fold_sine_;
}

double Skirt::radius(const dvec3& point) const {
  const double distance = std::hypot(point.x, point.y);
  const dvec2 once = distance > 0 ? dvec2(point) / distance : dvec2(1, 0);
  const dvec2 twice = doubled(once), eight = doubled(doubled(twice));
  const double down = 0.5 * (1 - point.z / shape_.half.z);  // 0 at the waist, 1 at the hem
  const double flare = down * (1 + kCurve - kCurve * down);
  const double fold = eight.y * fold_cosine_ - eight.x * fold_sine_;  // sin(8 angle - phase)
  return glm::mix(shape_.half.x, shape_.half.y, flare) +
         shape_.half.y * down * (kFold * fold - kPush * push_ * twice.y);
}

double Skirt::gap(const dvec3& point) const {
  return std::hypot(point.x, point.y) - radius(point);
}

double Skirt::depth(const dvec3& origin, const dvec3& direction, double begin, double end) const {
  constexpr int kHalvings = 30;
  const double length = glm::length(direction), shortest = kStep * shape_.half.y;
  double low = begin, before = gap(origin + low * direction);
  while (low < end) {
    const double high = std::min(end, low + std::max(std::abs(before) / kSlope, shortest) / length);
    const double after = gap(origin + high * direction);
    if ((before < 0) == (after < 0)) {
      low = high;
      before = after;
      continue;
    }
    double near = low, far = high;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (near + far);
      ((gap(origin + middle * direction) < 0) == (before < 0) ? near : far) = middle;
    }
    return 0.5 * (near + far);
  }
  return std::numeric_limits<double>::infinity();
}

dvec3 Skirt::normal(const dvec3& point) const {
  constexpr double kDifference = 1e-5;
  const double here = gap(point);
  dvec3 slope;
  for (int i = 0; i < 3; ++i) {
    dvec3 beside = point;
    beside[i] += kDifference;
    slope[i] = (gap(beside) - here) / kDifference;
  }
  return slope;
}

dvec3 Skirt::unrolled(const dvec3& point) const {
  return {shape_.half.y * std::atan2(point.x, -point.y), point.z, 0};
}

}  // namespace tessera::synth
