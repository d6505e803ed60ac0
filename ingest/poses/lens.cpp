// The distortion of all lens models, and the shortest focal length without blank pixels. Sources:
// Brown 1966; Kannala, Brandt 2006; Devernay, Faugeras 2001 (field of view).
#include "ingest/poses/lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr double kLongestFocal = 8;       // times the camera's own; beyond it little image is left
constexpr double kShortestFocal = 0.125;  // of a camera whose axis does not meet its image

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

glm::dvec2 in_pixels(const Camera& camera, const glm::dvec2& ray) {
  return {camera.fl_x * ray.x + camera.cx, camera.fl_y * ray.y + camera.cy};
}

bool has_axis_in_image(const Camera& camera) {
  return camera.cx >= 0 && camera.cy >= 0 && camera.cx <= camera.width &&
         camera.cy <= camera.height;
}

/// The length of the shortest ray (z = 1) of a pixel: 0 where the axis meets the image.
double shortest_ray(const Camera& camera) {
  const double x = std::clamp(camera.cx, 0.0, double(camera.width)) - camera.cx;
  const double y = std::clamp(camera.cy, 0.0, double(camera.height)) - camera.cy;
  return std::hypot(x / camera.fl_x, y / camera.fl_y);
}

/// Whether the ray meets the image, and the lens does not turn back on the way there from rays of
/// the length `from`: the image has none shorter, and its lens was never fitted to those.
bool meets_image(const Camera& camera, const Lens& lens, const glm::dvec2& ray, double from) {
  constexpr int kSteps = 16;
  constexpr double kProbe = 1e-4;
  const glm::dvec2 middle = lens.distorted({0, 0});
  const auto reach = [&](double part) { return glm::length(lens.distorted(ray * part) - middle); };
  const double first = from > 0 ? std::min(1.0, from / glm::length(ray)) : 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double part = first + (1 - first) * double(i) / kSteps;
    if (!(reach(part) > reach(part - kProbe))) return false;  // NaN too
  }
  const glm::dvec2 pixel = in_pixels(camera, lens.distorted(ray));
  return pixel.x >= 0 && pixel.y >= 0 && pixel.x <= camera.width && pixel.y <= camera.height;
}

/// Whether the border pixels' centres of `target` all meet the image.
bool sees_all(const Camera& camera, const Lens& lens, const Camera& target) {
  constexpr int kSamples = 128;  // along each side; distortion is smooth
  const double from = shortest_ray(target);
  for (int i = 0; i <= kSamples; ++i) {
    const double x = 0.5 + (target.width - 1) * double(i) / kSamples;
    const double y = 0.5 + (target.height - 1) * double(i) / kSamples;
    for (const glm::dvec2& pixel : {glm::dvec2(x, 0.5), glm::dvec2(x, target.height - 0.5),
                                    glm::dvec2(0.5, y), glm::dvec2(target.width - 0.5, y)})
      if (!meets_image(camera, lens,
                       {(pixel.x - target.cx) / target.fl_x, (pixel.y - target.cy) / target.fl_y},
                       from))
        return false;
  }
  return true;
}

Camera with_focal(Camera camera, double factor) {
  camera.fl_x *= factor;
  camera.fl_y *= factor;
  return camera;
}

/// Of another focal length, with `ray` in the middle of the image.
Camera with_focal_about(Camera camera, double factor, const glm::dvec2& ray) {
  camera = with_focal(camera, factor);
  camera.cx = 0.5 * camera.width - camera.fl_x * ray.x;
  camera.cy = 0.5 * camera.height - camera.fl_y * ray.y;
  return camera;
}

[[noreturn]] void refuse_turning(const std::string& where) {
  throw InputError(fmt::format(
      "{}: its lens distortion has no undistorted image of this size (it turns back on itself "
      "in the image); estimate this camera again, or run `colmap image_undistorter`",
      where));
}

/// The shortest focal length by `camera_of` from `too_short` on whose camera sees no blank pixels.
template <class CameraOf>
Camera shortest_focal(const Camera& camera, const Lens& lens, double too_short,
                      const CameraOf& camera_of, const std::string& where) {
  double enough = kLongestFocal;
  if (!sees_all(camera, lens, camera_of(enough))) refuse_turning(where);
  for (int i = 0; i < 24; ++i) {
    const double middle = 0.5 * (too_short + enough);
    (sees_all(camera, lens, camera_of(middle)) ? enough : too_short) = middle;
  }
  return camera_of(enough);
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

Camera undistorted_camera(const Camera& camera, const Lens& lens, const std::string& where) {
  if (lens.is_pinhole() || sees_all(camera, lens, camera)) return camera;
  if (has_axis_in_image(camera))
    return shortest_focal(
        camera, lens, 1, [&](double factor) { return with_focal(camera, factor); }, where);
  // a cropped sensor: a longer focal length would zoom to the axis, out of the image
  const std::optional<glm::dvec2> ray =
      lens.undistorted({(0.5 * camera.width - camera.cx) / camera.fl_x,
                        (0.5 * camera.height - camera.cy) / camera.fl_y});
  if (!ray) refuse_turning(where);
  return shortest_focal(
      camera, lens, kShortestFocal,
      [&](double factor) { return with_focal_about(camera, factor, *ray); }, where);
}

}  // namespace tessera
