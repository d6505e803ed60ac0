// One stored Gaussian of a canonical set: its nodes with their weights, and its mean and rotation
// in a view.
#pragma once
#include "kernels/load_gaussian.h"
#include "kernels/motion_nodes.h"

namespace tessera {

/// The nodes of Gaussian n, without weights. False where it is bound to none.
template <class Real>
TESSERA_HD inline bool load_nodes(const GaussianSpans<const Real>& set, int64_t n,
                                  Binding<Real>& binding) {
  const Real* const node = set.at(kNode, n);
  bool bound = false;
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) {
    binding.node[k] = int(node[k]);
    bound = bound || binding.node[k] >= 0;
  }
  return bound;
}

/// ‖x − p_k‖² at rest and ι_k of the nodes of Gaussian n.
template <class Real>
struct NodeDistances {
  Real distance2[kBindings], falloff[kBindings];
};
template <class Real>
TESSERA_HD inline NodeDistances<Real> node_distances(const NodeSpans<const Real>& nodes,
                                                     const Vec3<Real>& mean,
                                                     const Binding<Real>& binding) {
  NodeDistances<Real> d{};
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) {
    if (binding.node[k] < 0) continue;
    const Vec3<Real> offset = mean - load3(nodes.position.data + 3 * binding.node[k]);
    d.distance2[k] = dot(offset, offset);
    d.falloff[k] = node_falloff(nodes.log_radius[binding.node[k]]);
  }
  return d;
}

/// A Gaussian that is bound to no node is itself in every view.
template <class Real>
TESSERA_HD inline CarriedGaussian<Real> carried_in_view(bool bound, const Binding<Real>& binding,
                                                        const NodePose<Real>* poses,
                                                        const Vec3<Real>& mean,
                                                        const Vec4<Real>& rotation) {
  if (!bound) return {rotation, mean};
  const Carry<Real> carry = blend_poses(binding, poses);
  return {carried_rotation(carry, rotation), carried_mean(carry, mean)};
}

/// Control points of node m.
template <class T>
TESSERA_HD inline T* translation_of(const NodeSpans<T>& nodes, int64_t m) {
  return nodes.translation.data + 3 * nodes.knots * m;
}
template <class T>
TESSERA_HD inline T* rotation_of(const NodeSpans<T>& nodes, int64_t m) {
  return nodes.rotation.data + 4 * nodes.knots * m;
}

/// Writes the gradients by what is stored of node m. `d_poses`: [B, M] by its pose in each view;
/// `d_falloff`: by ι; `acceleration`: as CarryBackwardArgs::acceleration.
template <class Real>
TESSERA_HD inline void write_node_gradient(const NodeSpans<const Real>& nodes, int64_t m,
                                           const ViewArgs<Real>* views, int view_count,
                                           const NodePose<Real>* d_poses, Real d_falloff,
                                           Real acceleration, const NodeSpans<Real>& d_nodes) {
  Real* const d_translation = translation_of(d_nodes, m);
  Real* const d_rotation = rotation_of(d_nodes, m);
  for (int i = 0; i < nodes.knots; ++i) {
    for (int c = 0; c < 3; ++c)
      d_translation[3 * i + c] =
          acceleration *
          second_difference_gradient(translation_of(nodes, m) + c, nodes.knots, 3, i);
    for (int c = 0; c < 4; ++c) d_rotation[4 * i + c] = Real(0);
  }
  const Vec3<Real> position = load3(nodes.position.data + 3 * m);
  for (int b = 0; b < view_count; ++b) {
    const SplineWeights<Real> s = spline_weights(views[b].time, nodes.knots);
    const NodeGradient<Real> d =
        node_pose_backward(position, s, rotation_of(nodes, m), d_poses[b * nodes.count + m]);
    for (int i = 0; i < kSplineOrder; ++i) {
      for (int c = 0; c < 3; ++c)
        d_translation[3 * (s.first + i) + c] += s.weight[i] * d.translation[c];
      for (int c = 0; c < 4; ++c) d_rotation[4 * (s.first + i) + c] += s.weight[i] * d.rotation[c];
    }
  }
  d_nodes.log_radius[m] = Real(-2) * node_falloff(nodes.log_radius[m]) * d_falloff;
}

}  // namespace tessera
