// The epipolar geometry of two pinhole cameras. Source: Hartley and Zisserman, 2004, 9.2
// and 11.4.3.
#pragma once
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "kernels/base/camera.h"

namespace tessera {

/// F of pixels: x_bᵀ F x_a = 0.
inline glm::dmat3 fundamental(const Camera& a, const Camera& b) {
  const auto pixels = [](const Camera& c) {
    return glm::dmat3{{c.fl_x, 0, 0}, {0, c.fl_y, 0}, {c.cx, c.cy, 1}};
  };
  const glm::dmat3 turn = b.cam_from_world * glm::transpose(a.cam_from_world);
  const glm::dvec3 t = b.translation - turn * a.translation;
  const glm::dmat3 cross{{0, t.z, -t.y}, {-t.z, 0, t.x}, {t.y, -t.x, 0}};
  return glm::transpose(glm::inverse(pixels(b))) * cross * turn * glm::inverse(pixels(a));
}

/// A match of x_a and x_b by its lines F x_a and Fᵀ x_b. Its distance from the geometry of two
/// cameras is product / √square to first order, pixels [Sampson].
struct EpipolarMatch {
  double product, square;

  EpipolarMatch(const glm::dvec3& x_b, const glm::dvec3& line, const glm::dvec3& back)
      : product(glm::dot(x_b, line)),
        square(line.x * line.x + line.y * line.y + back.x * back.x + back.y * back.y) {}

  bool is_within(double pixels) const { return product * product < pixels * pixels * square; }
  double distance() const { return square > 0 ? product / std::sqrt(square) : 0; }
};

}  // namespace tessera
