// Scene extent and focus from camera centres and viewing axes. The poses are taken as given.
#include "kernels/base/camera_rig.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include "kernels/base/median.h"

namespace tessera {
namespace {

glm::dvec3 viewing_axis(const Camera& camera) {
  return glm::transpose(camera.cam_from_world)[2];
}

/// argmin_p Σ ‖(I − d dᵀ)(p − c)‖²; parallel axes have none, then a point ahead of the first
/// camera.
glm::dvec3 nearest_to_axes(const std::vector<Camera>& cameras, double fallback) {
  glm::dmat3 A(0.0);
  glm::dvec3 b(0.0);
  for (const Camera& camera : cameras) {
    const glm::dvec3 d = viewing_axis(camera);
    const glm::dmat3 across = glm::dmat3(1.0) - glm::outerProduct(d, d);
    A += across;
    b += across * camera.position();
  }
  const double n = double(cameras.size());
  if (glm::determinant(A) > 1e-6 * n * n * n) return glm::inverse(A) * b;
  return cameras[0].position() + fallback * viewing_axis(cameras[0]);
}

}  // namespace

double angle_at_focus(const CameraRig& rig, const Camera& a, const Camera& b) {
  const glm::dvec3 u = a.position() - rig.focus, v = b.position() - rig.focus;
  return glm::degrees(std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v)));
}

double neighbour_angle(const CameraRig& rig) {
  if (rig.cameras.size() < 3) return 0;
  std::vector<double> second;
  for (const Camera& camera : rig.cameras) {
    std::vector<double> angles;  // of it to itself, too
    for (const Camera& other : rig.cameras) angles.push_back(angle_at_focus(rig, camera, other));
    std::nth_element(angles.begin(), angles.begin() + 2, angles.end());
    second.push_back(angles[2]);
  }
  return median(std::move(second));
}

CameraRig make_camera_rig(const std::vector<Camera>& cameras) {
  constexpr double kExtentMargin = 1.1;  // [3DGS]
  CameraRig rig;
  for (const Camera& camera : cameras)
    if (std::find(rig.cameras.begin(), rig.cameras.end(), camera) == rig.cameras.end())
      rig.cameras.push_back(camera);
  glm::dvec3 mean(0.0);
  for (const Camera& camera : rig.cameras) mean += camera.position() / double(rig.cameras.size());
  for (const Camera& camera : rig.cameras)
    rig.extent = std::max(rig.extent, kExtentMargin * glm::distance(camera.position(), mean));
  // one camera, or all in one place: the scale cannot be determined; world units are taken as they
  // are
  if (!(rig.extent > 1e-6)) rig.extent = 1;

  rig.focus = nearest_to_axes(rig.cameras, rig.extent);
  std::vector<double> distances;
  double largest_tangent = 0;
  for (const Camera& camera : rig.cameras) {
    distances.push_back(glm::distance(camera.position(), rig.focus));
    largest_tangent = std::max(
        {largest_tangent, 0.5 * camera.width / camera.fl_x, 0.5 * camera.height / camera.fl_y});
  }
  rig.distance = std::max(median(std::move(distances)), 1e-6);
  rig.half_view = rig.distance * largest_tangent;
  return rig;
}

bool sees(const Camera& camera, const glm::dvec3& point, double near_plane) {
  const glm::dvec3 p = camera.cam_from_world * point + camera.translation;
  if (p.z < near_plane) return false;
  const double u = camera.fl_x * p.x / p.z + camera.cx, v = camera.fl_y * p.y / p.z + camera.cy;
  return u >= 0 && u <= camera.width && v >= 0 && v <= camera.height;
}

}  // namespace tessera
