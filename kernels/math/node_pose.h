// The pose of a motion node at a time: a uniform cubic B-spline of control points for its
// translation and its rotation, with gradients. Source: method D.9.
#pragma once
#include "kernels/math/rotation3.h"
#include "kernels/math/rotation4.h"

namespace tessera {

inline constexpr int kSplineOrder = 4;  // control points that act on a pose, and the least S

/// The control points that act at a time: weight[i] belongs to control point first + i.
template <class Real>
struct SplineWeights {
  int first;
  Real weight[kSplineOrder];  // not negative; their sum is 1
};

/// `time`: normalised; beyond [0, 1] it counts as the nearer end. `knots`: S ≥ 4 control points,
/// between whose S − 3 segments the second derivative is continuous.
template <class Real>
TESSERA_HD inline SplineWeights<Real> spline_weights(Real time, int knots) {
  const int segments = knots - kSplineOrder + 1;
  const Real u = clamp_to(time, Real(0), Real(1)) * Real(segments);
  SplineWeights<Real> s;
  s.first = 0;
  while (s.first < segments - 1 && u >= Real(s.first + 1)) ++s.first;
  const Real f = u - Real(s.first), rest = Real(1) - f;
  const Real sixth = Real(1) / Real(6);
  s.weight[0] = rest * rest * rest * sixth;
  s.weight[1] = Real(2) / Real(3) - f * f + f * f * f * Real(0.5);
  s.weight[2] = Real(2) / Real(3) - rest * rest + rest * rest * rest * Real(0.5);
  s.weight[3] = f * f * f * sixth;
  return s;
}

/// Carries x to R·x + τ and turns rotations by q. The same struct holds a gradient by these values;
/// then `rotation` and `quaternion` are not tied to each other.
template <class Real>
struct alignas(16) NodePose {
  Mat3<Real> rotation;     // R = R(q)
  Vec3<Real> translation;  // τ = p + T − R·p, world units
  Vec4<Real> quaternion;   // q, of length 1
};

/// Σ_i weight[i] · control[first + i], from [S, 3] or [S, 4] numbers.
template <class Vec, class Real>
TESSERA_HD inline Vec blend_controls(const SplineWeights<Real>& s, const Real* controls) {
  constexpr int width = Vec::length();
  Vec sum(Real(0));
  for (int i = 0; i < kSplineOrder; ++i)
    for (int c = 0; c < width; ++c) sum[c] += s.weight[i] * controls[(s.first + i) * width + c];
  return sum;
}

/// `translation`: [S, 3] of T, world units. `rotation`: [S, 4] of q before it is normalised; a
/// blend of no length leaves the node unturned.
template <class Real>
TESSERA_HD inline NodePose<Real> node_pose(const Vec3<Real>& position, const SplineWeights<Real>& s,
                                           const Real* translation, const Real* rotation) {
  const Vec4<Real> blend = blend_controls<Vec4<Real>>(s, rotation);
  NodePose<Real> pose;
  pose.quaternion =
      dot(blend, blend) >= kMinQuaternionNorm2<Real> ? normalised(blend) : Vec4<Real>(1, 0, 0, 0);
  pose.rotation = rotation_matrix(pose.quaternion);
  pose.translation =
      position + blend_controls<Vec3<Real>>(s, translation) - pose.rotation * position;
  return pose;
}

/// Gradients by the two blends of control points; that by control point first + i is weight[i]
/// times these.
template <class Real>
struct NodeGradient {
  Vec3<Real> translation;
  Vec4<Real> rotation;
};

template <class Real>
TESSERA_HD inline NodeGradient<Real> node_pose_backward(const Vec3<Real>& position,
                                                        const SplineWeights<Real>& s,
                                                        const Real* rotation,
                                                        const NodePose<Real>& d_pose) {
  NodeGradient<Real> d;
  d.translation = d_pose.translation;
  d.rotation = Vec4<Real>(Real(0));
  const Vec4<Real> blend = blend_controls<Vec4<Real>>(s, rotation);
  if (!(dot(blend, blend) >= kMinQuaternionNorm2<Real>)) return d;
  Mat3<Real> d_R = d_pose.rotation;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) d_R[c][r] -= d_pose.translation[r] * position[c];
  const Vec4<Real> q = normalised(blend);
  d.rotation = normalised_backward(blend, d_pose.quaternion + rotation_matrix_backward(q, d_R));
  return d;
}

/// The gradient by control i of S (numbers of one component, `stride` apart) of
/// Σ_j (c_{j−1} − 2 c_j + c_{j+1})² over the S − 2 inner controls.
template <class Real>
TESSERA_HD inline Real second_difference_gradient(const Real* controls, int knots, int stride,
                                                  int i) {
  const auto bend = [&](int j) {
    if (j < 1 || j > knots - 2) return Real(0);
    return controls[(j - 1) * stride] - Real(2) * controls[j * stride] + controls[(j + 1) * stride];
  };
  return Real(2) * (bend(i - 1) - Real(2) * bend(i) + bend(i + 1));
}

}  // namespace tessera
