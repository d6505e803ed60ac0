// A pair that moves: the two quaternions and scales of a Gaussian that is a ball of radius s in
// space at every time, moves with velocity v and lasts σ (one standard deviation). It is the
// inverse of pair_spacetime for isotropic Σ_c, in closed form [Yang24, Eqs. 7, 8].
#pragma once
#include <cmath>

#include "kernels/math/carry.h"
#include "kernels/math/rotation4.h"

namespace tessera {

struct MovingPair {
  Vec4<double> left, right;  // unit quaternions
  Vec3<double> log_scale;
  double log_scale_time;
};

/// In the plane of time and of d = v/|v| the covariance is [σ², |v| σ²; |v| σ², s² + |v|² σ²]. The
/// axis that is nearer to that of time is at the angle θ from it, |θ| ≤ π/4, and becomes the time
/// axis of the pair; the other one becomes its x axis. With h = (cos θ/2, d sin θ/2), which turns
/// by θ in that plane from both sides, and q, which turns x to d: l = h q, r = q* h. At rest both
/// are the identity.
inline MovingPair pair_at_velocity(double radius, double extent, const Vec3<double>& velocity) {
  const double speed = std::sqrt(dot(velocity, velocity));
  MovingPair pair{{1, 0, 0, 0}, {1, 0, 0, 0}, Vec3<double>(std::log(radius)), std::log(extent)};
  if (!(speed > 0)) return pair;
  const double a = extent * extent, b = speed * a, c = radius * radius + speed * b;
  const double angle = 0.5 * std::atan2(a >= c ? 2 * b : -2 * b, std::abs(a - c));
  const double larger = 0.5 * (a + c + std::hypot(a - c, 2 * b));
  const double smaller = a * radius * radius / larger;  // their product is the determinant
  const Vec3<double> d = velocity / speed;
  const Vec4<double> h(std::cos(angle / 2), std::sin(angle / 2) * d[0], std::sin(angle / 2) * d[1],
                       std::sin(angle / 2) * d[2]);
  // half-way between x and d, or about z where they are opposite
  const Vec4<double> half(1 + d[0], 0, -d[2], d[1]);
  const double length = std::sqrt(dot(half, half));
  const Vec4<double> q = length > 1e-9 ? half / length : Vec4<double>(0, 0, 0, 1);
  pair.left = quaternion_product(h, q);
  pair.right = quaternion_product(conjugate(q), h);
  pair.log_scale_time = 0.5 * std::log(a >= c ? larger : smaller);
  pair.log_scale[0] = 0.5 * std::log(a >= c ? smaller : larger);
  return pair;
}

}  // namespace tessera
