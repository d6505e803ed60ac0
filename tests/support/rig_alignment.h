// The distance of estimated camera poses from the true ones after the best similarity, because the
// world of an estimate has its own origin, rotation and scale. Source: Umeyama, Least-Squares
// Estimation of Transformation Parameters Between Two Point Patterns, 1991; the rotation as Horn's
// quaternion, 1987.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "kernels/base/camera.h"

namespace tessera::testing {

/// x_true = scale · rotation · x_estimated + shift.
struct Similarity {
  double scale = 1;
  glm::dmat3 rotation{1.0};
  glm::dvec3 shift{0.0};
  glm::dvec3 operator()(const glm::dvec3& x) const { return scale * (rotation * x) + shift; }
};

struct RigError {
  double rotation = 0;  // degrees, the largest of all cameras
  double centre = 0;    // the largest distance of two centres / extent of the true rig
  size_t worst_rotation = 0, worst_centre = 0;  // indices
  Similarity alignment;
};

/// The eigenvector of the largest eigenvalue of a symmetric matrix, by Jacobi's rotations.
inline std::array<double, 4> top_eigenvector(std::array<std::array<double, 4>, 4> a) {
  std::array<std::array<double, 4>, 4> v{};
  for (int i = 0; i < 4; ++i) v[i][i] = 1;
  for (int sweep = 0; sweep < 60; ++sweep)
    for (int p = 0; p < 4; ++p)
      for (int q = p + 1; q < 4; ++q) {
        if (a[p][q] == 0) continue;
        const double angle = 0.5 * std::atan2(2 * a[p][q], a[q][q] - a[p][p]);
        const double c = std::cos(angle), s = std::sin(angle);
        for (int k = 0; k < 4; ++k) {  // columns of a and v
          const double akp = a[k][p], akq = a[k][q];
          a[k][p] = c * akp - s * akq;
          a[k][q] = s * akp + c * akq;
          const double vkp = v[k][p], vkq = v[k][q];
          v[k][p] = c * vkp - s * vkq;
          v[k][q] = s * vkp + c * vkq;
        }
        for (int k = 0; k < 4; ++k) {  // rows of a
          const double apk = a[p][k], aqk = a[q][k];
          a[p][k] = c * apk - s * aqk;
          a[q][k] = s * apk + c * aqk;
        }
      }
  int top = 0;
  for (int i = 1; i < 4; ++i)
    if (a[i][i] > a[top][top]) top = i;
  return {v[0][top], v[1][top], v[2][top], v[3][top]};
}

/// The similarity that brings `from` nearest to `to` in the sum of squares.
inline Similarity align_points(const std::vector<glm::dvec3>& from,
                               const std::vector<glm::dvec3>& to) {
  glm::dvec3 from_mean(0);
  glm::dvec3 to_mean(0);
  for (size_t i = 0; i < from.size(); ++i) {
    from_mean += from[i];
    to_mean += to[i];
  }
  from_mean /= double(from.size());
  to_mean /= double(to.size());
  double s[3][3] = {}, spread = 0;  // s: sum of from · toᵀ
  for (size_t i = 0; i < from.size(); ++i) {
    const glm::dvec3 a = from[i] - from_mean, b = to[i] - to_mean;
    spread += glm::dot(a, a);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) s[r][c] += a[r] * b[c];
  }
  const double yz = s[1][2] - s[2][1], zx = s[2][0] - s[0][2], xy = s[0][1] - s[1][0];
  const auto q =
      top_eigenvector({{{s[0][0] + s[1][1] + s[2][2], yz, zx, xy},
                        {yz, s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
                        {zx, s[0][1] + s[1][0], s[1][1] - s[0][0] - s[2][2], s[1][2] + s[2][1]},
                        {xy, s[2][0] + s[0][2], s[1][2] + s[2][1], s[2][2] - s[0][0] - s[1][1]}}});
  Similarity result;
  result.rotation = glm::mat3_cast(glm::dquat(q[0], q[1], q[2], q[3]));
  double along = 0;
  for (size_t i = 0; i < from.size(); ++i)
    along += glm::dot(to[i] - to_mean, result.rotation * (from[i] - from_mean));
  result.scale = along / spread;
  result.shift = to_mean - result.scale * (result.rotation * from_mean);
  return result;
}

/// Largest distance of two centres.
inline double rig_extent(const std::vector<Camera>& cameras) {
  double extent = 0;
  for (const Camera& a : cameras)
    for (const Camera& b : cameras)
      extent = std::max(extent, glm::length(a.position() - b.position()));
  return extent;
}

/// The turn between two rotations, degrees; from the sine, which is exact for small ones.
inline double degrees_between(const glm::dmat3& one, const glm::dmat3& other) {
  const glm::dmat3 turn = glm::transpose(one) * other;
  const glm::dvec3 axis(turn[1][2] - turn[2][1], turn[2][0] - turn[0][2], turn[0][1] - turn[1][0]);
  const double cosine = (turn[0][0] + turn[1][1] + turn[2][2] - 1) / 2;
  return std::atan2(glm::length(axis) / 2, cosine) * 180 / M_PI;
}

/// The data of an alignment: a rig whose centres lie nearly in a plane or a line leaves the turn
/// of the world to small errors of the centres; the cameras' axes settle it.
enum class AlignBy { kPoses, kCentres };

/// The cameras' centres, with kPoses also the ends of their axes, as long as the rig is wide.
inline std::vector<glm::dvec3> alignment_points(const std::vector<Camera>& cameras, AlignBy by) {
  std::vector<glm::dvec3> points;
  for (const Camera& camera : cameras) points.push_back(camera.position());
  if (by == AlignBy::kCentres) return points;
  const double length = rig_extent(cameras);
  for (const Camera& camera : cameras)
    for (int axis = 0; axis < 3; ++axis)
      points.push_back(camera.position() + length * glm::transpose(camera.cam_from_world)[axis]);
  return points;
}

inline RigError rig_error(const std::vector<Camera>& estimated, const std::vector<Camera>& truth,
                          AlignBy by = AlignBy::kPoses) {
  RigError error;
  error.alignment = align_points(alignment_points(estimated, by), alignment_points(truth, by));
  const double extent = rig_extent(truth);
  for (size_t i = 0; i < truth.size(); ++i) {
    const glm::dmat3 aligned =
        estimated[i].cam_from_world * glm::transpose(error.alignment.rotation);
    const double turn = degrees_between(aligned, truth[i].cam_from_world);
    const double distance =
        glm::length(error.alignment(estimated[i].position()) - truth[i].position()) / extent;
    if (turn > error.rotation) {
      error.rotation = turn;
      error.worst_rotation = i;
    }
    if (distance > error.centre) {
      error.centre = distance;
      error.worst_centre = i;
    }
  }
  return error;
}

}  // namespace tessera::testing
