// Intersections with solid shapes in closed form, and with the cloth by ray marching. There is no
// acceleration structure: a world has a few dozen shapes, and movers have bounding boxes in the
// image.
#include "tools/synth/shape.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "tools/synth/skirt.h"

namespace tessera::synth {
namespace {

using glm::dvec3;

constexpr double kNearest = 1e-7;    // depths below it are the surface a ray starts on
constexpr double kClothReach = 1.3;  // largest |height| of the cloth by half.z

int largest_axis(const dvec3& v) {
  const dvec3 m = glm::abs(v);
  return m.x > m.y && m.x > m.z ? 0 : m.y > m.z ? 1 : 2;
}

bool accept(double depth, ShapeHit& hit) {
  if (!(depth > kNearest && depth < hit.depth)) return false;
  hit.depth = depth;
  return true;
}

bool meet_quad(const Shape& shape, const dvec3& o, const dvec3& d, ShapeHit& hit) {
  const double depth = -o.z / d.z;  // ±inf or NaN for a parallel ray: refused by accept
  const dvec3 p = o + depth * d;
  if (!(std::abs(p.x) <= shape.half.x && std::abs(p.y) <= shape.half.y)) return false;
  if (!accept(depth, hit)) return false;
  hit.point = {p.x, p.y, 0};
  hit.normal = {0, 0, 1};
  hit.axis = 2;
  return true;
}

/// Depths at which the ray enters and leaves the box; enter > leave: it misses.
struct Crossing {
  double enter, leave;
  int enter_axis, leave_axis;
};

Crossing cross_box(const dvec3& half, const dvec3& o, const dvec3& d) {
  Crossing c{-1e300, 1e300, 0, 0};
  for (int i = 0; i < 3; ++i) {
    const double inverse = 1 / d[i];
    const double a = (-half[i] - o[i]) * inverse, b = (half[i] - o[i]) * inverse;
    const double low = std::min(a, b), high = std::max(a, b);
    if (low > c.enter) {
      c.enter = low;
      c.enter_axis = i;
    }
    if (high < c.leave) {
      c.leave = high;
      c.leave_axis = i;
    }
  }
  return c;
}

bool meet_box(const Shape& shape, const dvec3& o, const dvec3& d, ShapeHit& hit) {
  const Crossing c = cross_box(shape.half, o, d);
  if (c.enter > c.leave) return false;
  const bool outside = c.enter > kNearest;
  if (!accept(outside ? c.enter : c.leave, hit)) return false;
  hit.axis = outside ? c.enter_axis : c.leave_axis;
  hit.point = o + hit.depth * d;
  hit.normal = dvec3(0);
  hit.normal[hit.axis] = hit.point[hit.axis] < 0 ? -1 : 1;
  return true;
}

bool meet_sphere(const Shape& shape, const dvec3& o, const dvec3& d, ShapeHit& hit) {
  const double a = glm::dot(d, d), b = glm::dot(o, d);
  const double c = glm::dot(o, o) - shape.half.x * shape.half.x, discriminant = b * b - a * c;
  if (discriminant < 0) return false;
  const double root = std::sqrt(discriminant);
  if (!accept((-b - root) / a, hit) && !accept((-b + root) / a, hit)) return false;
  hit.point = o + hit.depth * d;
  hit.normal = hit.point;
  hit.axis = largest_axis(hit.normal);
  return true;
}

bool meet_cylinder(const Shape& shape, const dvec3& o, const dvec3& d, ShapeHit& hit) {
  const double r2 = shape.half.x * shape.half.x;
  bool met = false;
  const double a = d.x * d.x + d.y * d.y, b = o.x * d.x + o.y * d.y;
  const double discriminant = b * b - a * (o.x * o.x + o.y * o.y - r2);
  if (discriminant < 0) return false;  // the caps lie inside the infinite cylinder
  for (const double sign : {-1.0, 1.0}) {
    const double depth = (-b + sign * std::sqrt(discriminant)) / a;
    const dvec3 p = o + depth * d;
    if (!(std::abs(p.z) <= shape.half.z) || !accept(depth, hit)) continue;
    hit.point = p;
    hit.normal = {p.x, p.y, 0};
    hit.axis = largest_axis(hit.normal);
    met = true;
  }
  for (const double sign : {-1.0, 1.0}) {
    const double depth = (sign * shape.half.z - o.z) / d.z;
    const dvec3 p = o + depth * d;
    if (!(p.x * p.x + p.y * p.y <= r2) || !accept(depth, hit)) continue;
    hit.point = p;
    hit.normal = {0, 0, sign};
    hit.axis = 2;
    met = true;
  }
  return met;
}

bool meet_ball(double height, double radius, const dvec3& o, const dvec3& d, ShapeHit& hit) {
  const dvec3 centre(0, 0, height);
  if (!meet_sphere({ShapeKind::kSphere, dvec3(radius)}, o - centre, d, hit)) return false;
  hit.point += centre;
  return true;
}

/// From outside; a ray from within may meet what lies inside the hull.
bool meet_round_cone(const Shape& shape, const dvec3& o, const dvec3& d, ShapeHit& hit) {
  const double low = shape.half.x, high = shape.half.y, length = 2 * shape.half.z;
  bool met = meet_ball(-shape.half.z, low, o, d, hit);
  met |= meet_ball(shape.half.z, high, o, d, hit);
  // The cone touches both balls: cosine · distance from the axis = low - sine · height.
  const double sine = (low - high) / length, cosine2 = 1 - sine * sine;
  const double first = o.z + shape.half.z, rest = low - sine * first;
  const double a = cosine2 * (d.x * d.x + d.y * d.y) - sine * sine * d.z * d.z;
  const double b = cosine2 * (o.x * d.x + o.y * d.y) + sine * rest * d.z;
  const double c = cosine2 * (o.x * o.x + o.y * o.y) - rest * rest, discriminant = b * b - a * c;
  if (discriminant < 0) return met;
  for (const double sign : {-1.0, 1.0}) {
    const double depth = (-b + sign * std::sqrt(discriminant)) / a, height = first + depth * d.z;
    if (!(height >= low * sine && height <= length + high * sine) || !accept(depth, hit)) continue;
    hit.point = o + depth * d;
    hit.normal = {cosine2 * hit.point.x, cosine2 * hit.point.y, sine * (low - sine * height)};
    hit.axis = largest_axis(hit.normal);
    met = true;
  }
  return met;
}

bool meet_skirt(const Shape& shape, const dvec3& o, const dvec3& d, double time, ShapeHit& hit) {
  const double reach = skirt_reach(shape);
  const Crossing c = cross_box({reach, reach, shape.half.z}, o, d);
  const double begin = std::max(c.enter, kNearest), end = std::min(c.leave, hit.depth);
  if (!(begin < end)) return false;
  const Skirt skirt(shape, time);
  if (!accept(skirt.depth(o, d, begin, end), hit)) return false;
  const dvec3 point = o + hit.depth * d;
  hit.point = skirt.unrolled(point);
  hit.normal = skirt.normal(point);
  hit.axis = 2;
  return true;
}

bool meet_cloth(const Shape& shape, const dvec3& o, const dvec3& d, double time, ShapeHit& hit) {
  constexpr int kSteps = 28, kHalvings = 18;
  const Crossing c = cross_box({shape.half.x, shape.half.y, kClothReach * shape.half.z}, o, d);
  const double begin = std::max(c.enter, kNearest), end = std::min(c.leave, hit.depth);
  if (!(begin < end)) return false;
  const auto gap = [&](double depth) {
    const dvec3 p = o + depth * d;
    return p.z - cloth_height(shape, p.x, p.y, time);
  };
  double low = begin, before = gap(low), high = end;
  for (int i = 1; i <= kSteps; ++i) {
    high = begin + (end - begin) * i / kSteps;
    const double after = gap(high);
    if ((before < 0) != (after < 0)) break;
    if (i == kSteps) return false;
    low = high;
    before = after;
  }
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    ((gap(middle) < 0) == (before < 0) ? low : high) = middle;
  }
  if (!accept(0.5 * (low + high), hit)) return false;
  constexpr double kStep = 1e-4;
  const dvec3 p = o + hit.depth * d;
  const double h = cloth_height(shape, p.x, p.y, time);
  const double slope_x = (cloth_height(shape, p.x + kStep, p.y, time) - h) / kStep;
  const double slope_y = (cloth_height(shape, p.x, p.y + kStep, time) - h) / kStep;
  hit.point = {p.x, p.y, 0};  // the texture is fixed to the flat cloth
  hit.normal = {-slope_x, -slope_y, 1};
  hit.axis = 2;
  return true;
}

}  // namespace

double cloth_height(const Shape& shape, double x, double y, double time) {
  const double free = 0.5 * (1 - y / shape.half.y);  // 0 at the pinned edge, 1 at the free one
  const double turn = 2 * std::numbers::pi;
  const double u = x / shape.half.x, phase = shape.wave_cycles * time;
  return shape.half.z * free *
         (std::sin(turn * (0.75 * u - phase)) +
          0.3 * std::sin(turn * (0.9 * free - 0.4 * u - 2 * phase)));
}

bool intersect(const Shape& shape, const dvec3& origin, const dvec3& direction, double time,
               ShapeHit& hit) {
  switch (shape.kind) {
    case ShapeKind::kQuad:
      return meet_quad(shape, origin, direction, hit);
    case ShapeKind::kBox:
      return meet_box(shape, origin, direction, hit);
    case ShapeKind::kSphere:
      return meet_sphere(shape, origin, direction, hit);
    case ShapeKind::kCylinder:
      return meet_cylinder(shape, origin, direction, hit);
    case ShapeKind::kRoundCone:
      return meet_round_cone(shape, origin, direction, hit);
    case ShapeKind::kCloth:
      return meet_cloth(shape, origin, direction, time, hit);
    case ShapeKind::kSkirt:
      return meet_skirt(shape, origin, direction, time, hit);
  }
  return false;
}

double bounding_radius(const Shape& shape) {
  const dvec3& h = shape.half;
  switch (shape.kind) {
    case ShapeKind::kQuad:
      return std::hypot(h.x, h.y);
    case ShapeKind::kBox:
      return glm::length(h);
    case ShapeKind::kSphere:
      return h.x;
    case ShapeKind::kCylinder:
      return std::hypot(h.x, h.z);
    case ShapeKind::kRoundCone:
      return h.z + std::max(h.x, h.y);
    case ShapeKind::kSkirt:
      return std::hypot(skirt_reach(shape), h.z);
    case ShapeKind::kCloth:
      return glm::length(dvec3(h.x, h.y, kClothReach * h.z));
  }
  return 0;
}

}  // namespace tessera::synth
