// The distortion of all lens models. Sources: Brown 1966; Kannala, Brandt 2006; Devernay, Faugeras
// 2001 (field of view).
#include "ingest/poses/lens.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace tessera {
namespace {

/// ρ / r of the projection.
double bending(const Lens& lens, double r) {
  if (r < 1e-9) r = 1e-9;  // the limit for r → 0, to rounding
  switch (lens.projection) {
    case Lens::Projection::kPinhole:
      return 1;
    case Lens::Projection::kFisheye:
      return std::atan(r) / r;
    case Lens::Projection::kFieldOfView:
      return std::abs(lens.omega) < 1e-9
                 ? 1
                 : std::atan(2 * r * std::tan(0.5 * lens.omega)) / (lens.omega * r);
  }
  return 1;
}

/// r / ρ of the projection; nothing where no ray with z = 1 is bent to ρ.
std::optional<double> unbending(const Lens& lens, double rho) {
  if (rho < 1e-9) rho = 1e-9;
  const double quarter = 0.5 * std::numbers::pi;
  switch (lens.projection) {
    case Lens::Projection::kPinhole:
      return 1;
    case Lens::Projection::kFisheye:
      return rho < quarter ? std::optional(std::tan(rho) / rho) : std::nullopt;
    case Lens::Projection::kFieldOfView:
      if (std::abs(lens.omega) < 1e-9) return 1;
      return std::abs(rho * lens.omega) < quarter
                 ? std::optional(std::tan(rho * lens.omega) /
                                 (2 * std::tan(0.5 * lens.omega) * rho))
                 : std::nullopt;
  }
  return 1;
}

}  // namespace

bool Lens::is_pinhole() const {
  for (const double value : {k1, k2, k3, k4, d1, d2, d3, p1, p2, s1, s2})
    if (value != 0) return false;
  return projection == Projection::kPinhole ||
         (projection == Projection::kFieldOfView && omega == 0);
}

glm::dvec2 Lens::distorted(const glm::dvec2& ray) const {
  const glm::dvec2 bent = ray * bending(*this, glm::length(ray));
  const double x = bent.x, y = bent.y, r2 = x * x + y * y;
  const double radial =
      (1 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4)))) / (1 + r2 * (d1 + r2 * (d2 + r2 * d3)));
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + s1 * r2,
          y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y) + s2 * r2};
}

std::optional<glm::dvec2> Lens::undistorted(const glm::dvec2& met) const {
  if (is_pinhole()) return met;
  constexpr int kSteps = 100;
  constexpr double kExact = 1e-13;  // of a ray with z = 1; a step that small ends the search
  glm::dvec2 bent = met;            // Newton's method on the ray after the projection,
  if (const double reach = glm::length(met), quarter = 0.5 * std::numbers::pi;
      projection == Projection::kFisheye && reach > quarter)
    bent *= quarter / reach;  // from no more than 90 degrees, beyond which polynomials may turn
  Lens radial = *this;
  radial.projection = Projection::kPinhole;
  double error = glm::length(radial.distorted(bent) - met);
  for (int i = 0; i < kSteps && error > kExact; ++i) {
    constexpr double kDelta = 1e-6;  // central differences: error of its square
    const glm::dvec2 dx = (radial.distorted(bent + glm::dvec2(kDelta, 0)) -
                           radial.distorted(bent - glm::dvec2(kDelta, 0))) /
                          (2 * kDelta);
    const glm::dvec2 dy = (radial.distorted(bent + glm::dvec2(0, kDelta)) -
                           radial.distorted(bent - glm::dvec2(0, kDelta))) /
                          (2 * kDelta);
    const double determinant = dx.x * dy.y - dx.y * dy.x;
    if (!(determinant > 1e-9)) return std::nullopt;  // 1 without distortion, 0 where it turns
    const glm::dvec2 off = radial.distorted(bent) - met;
    const glm::dvec2 step(-(dy.y * off.x - dy.x * off.y) / determinant,
                          -(dx.x * off.y - dx.y * off.x) / determinant);
    double part = 1, reached = 0;
    for (; part > 1e-3; part *= 0.5) {
      reached = glm::length(radial.distorted(bent + part * step) - met);
      if (reached < error) break;
    }
    if (!(reached < error)) break;  // rounding is all that is left
    bent += part * step;
    error = reached;
  }
  if (!(error < 1e-10)) return std::nullopt;
  const std::optional<double> factor = unbending(*this, glm::length(bent));
  return factor ? std::optional(*factor * bent) : std::nullopt;
}

double Lens::outward_reach(double from, double to) const {
  constexpr int kDirections = 16, kSteps = 2048;
  const glm::dvec2 middle = distorted({0, 0});
  double reach = to;
  for (int k = 0; k < kDirections; ++k) {
    const double turn = 2 * std::numbers::pi * k / kDirections;
    const glm::dvec2 direction(std::cos(turn), std::sin(turn));
    double before = from, last = glm::length(distorted(direction * from) - middle);
    for (int i = 1; i <= kSteps && before < reach; ++i) {
      const double length = from + (to - from) * double(i) / kSteps;
      const double met = glm::length(distorted(direction * length) - middle);
      if (!(met > last)) reach = before;  // NaN too
      before = length;
      last = met;
    }
  }
  return reach;
}

}  // namespace tessera
