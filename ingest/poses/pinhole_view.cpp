// The shortest focal length without blank pixels, and the image that holds the rays of the border.
#include "ingest/poses/pinhole_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr double kLongestFocal = 8;       // times the camera's own; beyond it little image is left
constexpr double kShortestFocal = 0.125;  // of a camera whose axis does not meet its image
constexpr double kWidest = 1.7320508;     // tan 60 degrees, to either side of a full view

glm::dvec2 in_pixels(const Camera& camera, const glm::dvec2& ray) {
  return {camera.fl_x * ray.x + camera.cx, camera.fl_y * ray.y + camera.cy};
}

bool has_axis_in_image(const Camera& camera) {
  return camera.cx >= 0 && camera.cy >= 0 && camera.cx <= camera.width &&
         camera.cy <= camera.height;
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

/// The camera without blank pixels. The principal point is the camera's, the focal length too or as
/// much longer as that needs. Where the camera's axis does not meet its image (a cropped sensor)
/// and its own focal length does not do, the middle of the image stays in the middle, and the focal
/// length is the shortest without blank pixels.
Camera valid_camera(const Camera& camera, const Lens& lens, const std::string& where) {
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

/// The camera of the same focal length whose image has all that `camera` shows within kWidest;
/// nothing where the lens turns back before half of the image.
std::optional<Camera> full_camera(const Camera& camera, const Lens& lens) {
  constexpr int kSamples = 128;  // along each side
  const double infinity = std::numeric_limits<double>::infinity();
  const double reach = lens.outward_reach(shortest_ray(camera), kFarthestRay);
  glm::dvec2 low(infinity), high(-infinity);
  const auto include = [&](double x, double y) {
    const glm::dvec2 met((x - camera.cx) / camera.fl_x, (y - camera.cy) / camera.fl_y);
    std::optional<glm::dvec2> ray = lens.undistorted(met);
    if (!ray || glm::length(*ray) > reach) ray = reach / glm::length(met) * met;
    low = glm::min(low, *ray);
    high = glm::max(high, *ray);
  };
  for (int i = 0; i <= kSamples; ++i) {
    const double x = camera.width * double(i) / kSamples, y = camera.height * double(i) / kSamples;
    for (const double side : {0.0, double(camera.height)}) include(x, side);
    for (const double side : {0.0, double(camera.width)}) include(side, y);
  }
  const double half = 0.5 * std::min(camera.width / camera.fl_x, camera.height / camera.fl_y);
  if (reach < half) return std::nullopt;
  low = glm::max(low, glm::dvec2(-kWidest));
  high = glm::min(high, glm::dvec2(kWidest));
  Camera full = camera;
  full.width = int(std::ceil((high.x - low.x) * camera.fl_x));
  full.height = int(std::ceil((high.y - low.y) * camera.fl_y));
  full.cx = -low.x * camera.fl_x;
  full.cy = -low.y * camera.fl_y;
  return full;
}

/// Whether `valid` shows less than most of the width or the height of `full`.
bool cuts_much(const Camera& valid, const Camera& full) {
  constexpr double kMost = 0.9;
  return valid.width / valid.fl_x < kMost * full.width / full.fl_x ||
         valid.height / valid.fl_y < kMost * full.height / full.fl_y;
}

PinholeView undistorted_view(const Camera& camera, const Lens& lens, FieldOfView kept,
                             const std::string& where) {
  if (kept == FieldOfView::kValid) return {valid_camera(camera, lens, where)};
  const bool is_stated = kept == FieldOfView::kFull;
  std::optional<Camera> valid, full = full_camera(camera, lens);
  if (!full && is_stated) refuse_turning(where);
  if (!is_stated) try {
      valid = valid_camera(camera, lens, where);
    } catch (const InputError&) {
      if (!full) throw;
    }
  if (valid && (!full || !cuts_much(*valid, *full))) return {*valid};
  return {*full, FieldOfView::kFull, !sees_all(camera, lens, *full)};
}

}  // namespace

double shortest_ray(const Camera& camera) {
  const double x = std::clamp(camera.cx, 0.0, double(camera.width)) - camera.cx;
  const double y = std::clamp(camera.cy, 0.0, double(camera.height)) - camera.cy;
  return std::hypot(x / camera.fl_x, y / camera.fl_y);
}

PinholeView pinhole_view(const Camera& camera, const Lens& lens, FieldOfView kept,
                         const std::string& where) {
  if (lens.is_pinhole()) return {camera};
  PinholeView view = undistorted_view(camera, lens, kept, where);
  const double rows = view.camera.height / view.camera.fl_y * camera.fl_y / camera.height;
  view.camera.readout = camera.readout * rows;  // of those that it shows
  return view;
}

}  // namespace tessera
