// Checks a stated pose, flips the axes and inverts the rigid transform. A matrix that is not a
// rotation is refused.
#include "ingest/poses/pose_matrix.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr double kRotationTolerance = 1e-3;  // largest |RᵀR − I| taken for rounding

[[noreturn]] void fail(const std::string& where, const std::string& seen) {
  throw InputError(
      fmt::format("{}: {}; expected a rotation and a finite camera centre: correct this pose or "
                  "remove the frame",
                  where, seen));
}

double largest_deviation(const glm::dmat3& rotation) {
  const glm::dmat3 residual = glm::transpose(rotation) * rotation - glm::dmat3(1.0);
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(residual[c][r]));
  return largest;
}

void check_rotation(const glm::dmat3& rotation, const std::string& where) {
  const double determinant = glm::determinant(rotation);
  double length_product = 1;
  for (int c = 0; c < 3; ++c) length_product *= glm::length(rotation[c]);
  if (length_product == 0 || std::abs(determinant) < 1e-6 * length_product)
    fail(where, fmt::format("the pose is singular (determinant {:.3g})", determinant));
  if (determinant < 0)
    fail(where, fmt::format("the pose is a mirror image (determinant {:.3g})", determinant));
  const double deviation = largest_deviation(rotation);
  if (deviation > kRotationTolerance)
    fail(where, fmt::format("the pose is scaled or sheared (columns of length {:.4g}, {:.4g}, "
                            "{:.4g}; largest deviation of R'R from 1 is {:.3g})",
                            glm::length(rotation[0]), glm::length(rotation[1]),
                            glm::length(rotation[2]), deviation));
}

/// The nearest rotation: Newton's iteration of the polar decomposition, quadratic from 1e-3.
glm::dmat3 nearest_rotation(glm::dmat3 rotation) {
  for (int i = 0; i < 4 && largest_deviation(rotation) > 1e-15; ++i)
    rotation = 0.5 * (rotation + glm::transpose(glm::inverse(rotation)));
  return rotation;
}

}  // namespace

void set_pose(Camera& camera, const PoseRows& world_from_gl_camera, const std::string& where) {
  glm::dmat3 rotation;
  glm::dvec3 centre;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) {
      const double value = world_from_gl_camera[size_t(r)][size_t(c)];
      if (!std::isfinite(value))
        fail(where,
             fmt::format("the pose has a value that is not finite in row {}, column {}", r, c));
      (c < 3 ? rotation[c][r] : centre[r]) = value;
    }
  check_rotation(rotation, where);
  rotation = nearest_rotation(rotation);
  rotation[1] = -rotation[1];
  rotation[2] = -rotation[2];
  camera.cam_from_world = glm::transpose(rotation);
  camera.translation = -(camera.cam_from_world * centre);
}

PoseRows gl_pose_of(const Camera& camera) {
  const glm::dmat3 rotation = glm::transpose(camera.cam_from_world);
  const glm::dvec3 centre = camera.position();
  PoseRows rows{};
  for (int r = 0; r < 3; ++r)
    rows[size_t(r)] = {rotation[0][r], -rotation[1][r], -rotation[2][r], centre[r]};
  return rows;
}

}  // namespace tessera
