// A Gaussian that motion nodes carry: the weights of the nodes that it is bound to, the blend of
// their poses, and the gradients of both. Source: method D.9.
#pragma once
#include "kernels/math/node_pose.h"

namespace tessera {

inline constexpr int kBindings = 8;  // K: nodes that a Gaussian can be bound to

/// The nodes of a Gaussian and how much each counts.
template <class Real>
struct Binding {
  int node[kBindings];     // in [0, M), or −1: none
  Real weight[kBindings];  // not negative; their sum is 1, or all are 0 where there is no node
};

/// Hamilton product a·b.
template <class Real>
TESSERA_HD inline Vec4<Real> quaternion_product(const Vec4<Real>& a, const Vec4<Real>& b) {
  return Vec4<Real>(a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]);
}

/// ι = 1/(2 r²) from ln r: by how much a node's logit falls per squared distance.
template <class Real>
TESSERA_HD inline Real node_falloff(Real log_radius) {
  return Real(0.5) * exp(Real(-2) * log_radius);
}

/// weight ← softmax over the nodes k ≥ 0 of f_k − ι_k d²_k. `distance2`: squared distances at rest,
/// world units². What belongs to no node is not read.
template <class Real>
TESSERA_HD inline void binding_weights(const Real* logit, const Real* falloff,
                                       const Real* distance2, Binding<Real>& binding) {
  Real largest = Real(0), sum = Real(0);
  bool found = false;
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) {
    binding.weight[k] = Real(0);
    if (binding.node[k] < 0) continue;
    binding.weight[k] = logit[k] - falloff[k] * distance2[k];
    largest = found ? max_of(largest, binding.weight[k]) : binding.weight[k];
    found = true;
  }
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) {
    if (binding.node[k] < 0) continue;
    binding.weight[k] = exp(binding.weight[k] - largest);
    sum += binding.weight[k];
  }
  const Real scale = found ? Real(1) / sum : Real(0);
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) binding.weight[k] *= scale;
}

/// d_logit[k] = w_k (G_k − Σ_j w_j G_j), G = `d_weight`. The gradient by ι_k is −d²_k · d_logit[k],
/// that by ln r_k is −2 ι_k times this; none goes to the distances.
template <class Real>
TESSERA_HD inline void binding_weights_backward(const Binding<Real>& binding, const Real* d_weight,
                                                Real* d_logit) {
  Real mean = Real(0);
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) mean += binding.weight[k] * d_weight[k];
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) d_logit[k] = binding.weight[k] * (d_weight[k] - mean);
}

/// What the nodes of a Gaussian do to it in one view: x ↦ linear·x + offset, q ↦ turn ⊗ q.
template <class Real>
struct Carry {
  Mat3<Real> linear;        // Σ w R
  Vec3<Real> offset;        // Σ w τ
  Vec4<Real> turn;          // Σ ±w q
  bool flipped[kBindings];  // whether the sign of a node's quaternion is −
};

/// Quaternions count with the sign that turns them towards that of the heaviest node: q and −q are
/// the same rotation. `poses`: [M] of the view.
template <class Real>
TESSERA_HD inline Carry<Real> blend_poses(const Binding<Real>& binding,
                                          const NodePose<Real>* poses) {
  int heaviest = -1;
  Real most = Real(0);
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) {
    if (binding.node[k] < 0 || (heaviest >= 0 && !(binding.weight[k] > most))) continue;
    most = binding.weight[k];
    heaviest = binding.node[k];
  }
  Carry<Real> c;
  c.linear = Mat3<Real>(Real(0));
  c.offset = Vec3<Real>(Real(0));
  c.turn = Vec4<Real>(Real(0));
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) {
    c.flipped[k] = false;
    if (binding.node[k] < 0) continue;
    const NodePose<Real>& pose = poses[binding.node[k]];
    const Real w = binding.weight[k];
    c.flipped[k] = dot(pose.quaternion, poses[heaviest].quaternion) < Real(0);
    c.linear += pose.rotation * w;
    c.offset += pose.translation * w;
    c.turn += pose.quaternion * (c.flipped[k] ? -w : w);
  }
  return c;
}

/// A Gaussian of a canonical set as a view sees it, or the gradient by that.
template <class Real>
struct alignas(4 * sizeof(Real)) CarriedGaussian {
  Vec4<Real> rotation;  // w,x,y,z, not normalised
  Vec3<Real> mean;      // world units
};

template <class Real>
TESSERA_HD inline Vec3<Real> carried_mean(const Carry<Real>& c, const Vec3<Real>& mean) {
  return c.linear * mean + c.offset;
}

/// Not normalised.
template <class Real>
TESSERA_HD inline Vec4<Real> carried_rotation(const Carry<Real>& c, const Vec4<Real>& rotation) {
  return quaternion_product(c.turn, rotation);
}

/// Of one Gaussian in one view.
template <class Real>
struct CarryGradient {
  Vec3<Real> mean;              // by the mean at rest
  Vec4<Real> rotation;          // by the rotation at rest
  Vec4<Real> turn;              // b = h ⊗ conj(q)
  Real weight[kBindings] = {};  // G_k
};

/// The gradient of a node's pose by what one Gaussian is in one view: w {g ⊗ x, g, ±b}.
template <class Real>
TESSERA_HD inline NodePose<Real> node_share(Real weight, bool flipped, const Vec3<Real>& mean,
                                            const Vec3<Real>& d_mean, const Vec4<Real>& d_turn) {
  NodePose<Real> d;
  for (int c = 0; c < 3; ++c) d.rotation[c] = d_mean * (weight * mean[c]);
  d.translation = d_mean * weight;
  d.quaternion = d_turn * (flipped ? -weight : weight);
  return d;
}

/// `d_mean`: g, by the carried mean; `d_rotation`: h, by the carried rotation.
template <class Real>
TESSERA_HD inline CarryGradient<Real> carry_backward(const Binding<Real>& binding,
                                                     const NodePose<Real>* poses,
                                                     const Carry<Real>& c, const Vec3<Real>& mean,
                                                     const Vec4<Real>& rotation,
                                                     const Vec3<Real>& d_mean,
                                                     const Vec4<Real>& d_rotation) {
  CarryGradient<Real> d;
  for (int i = 0; i < 3; ++i) d.mean[i] = dot(Vec3<Real>(c.linear[i]), d_mean);
  d.rotation = quaternion_product(conjugate(c.turn), d_rotation);
  d.turn = quaternion_product(d_rotation, conjugate(rotation));
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) {
    if (binding.node[k] < 0) continue;
    const NodePose<Real>& pose = poses[binding.node[k]];
    const Real turned = dot(pose.quaternion, d.turn);
    d.weight[k] =
        dot(d_mean, pose.rotation * mean + pose.translation) + (c.flipped[k] ? -turned : turned);
  }
  return d;
}

}  // namespace tessera
