// Canonical Gaussians carried by motion nodes into the views of a batch, and the backward pass:
// gradients at rest, of the logits and of the nodes. Equations: kernels/math/carry.h,
// kernels/math/node_pose.h.
#include <algorithm>
#include <atomic>
#include <vector>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/stages/carry.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 512;  // Gaussians per task
/// Sums over nodes are added up in this many parts, whatever the number of threads.
constexpr int64_t kParts = 64;

/// Sums over the Gaussians of a part.
template <class Real>
struct NodeSums {
  std::vector<NodePose<Real>> pose;  // [B, M]
  std::vector<Real> falloff;         // [M] by ι
};

template <class Real>
NodeSums<Real> zero_sums(size_t views, int64_t nodes) {
  NodePose<Real> zero;
  zero.rotation = Mat3<Real>(Real(0));
  zero.translation = Vec3<Real>(Real(0));
  zero.quaternion = Vec4<Real>(Real(0));
  return {std::vector<NodePose<Real>>(views * size_t(nodes), zero),
          std::vector<Real>(size_t(nodes), Real(0))};
}

template <class Real>
void add_to(NodePose<Real>& sum, const NodePose<Real>& o) {
  sum.rotation += o.rotation;
  sum.translation += o.translation;
  sum.quaternion += o.quaternion;
}

template <class Real>
struct ElementBackward {
  const CarryBackwardArgs<Real>& args;

  /// Gradient of Gaussian n at rest; its share of the nodes' is added to `sums`.
  CarriedGradient<Real> operator()(int64_t n, NodeSums<Real>& sums) const {
    const CarryArgs<Real>& forward = args.forward;
    const int64_t count = forward.set.count, nodes = forward.nodes.count;
    const Vec3<Real> mean = load3(forward.set.at(kMean, n));
    const Vec4<Real> rotation = load4(forward.set.at(kRotation, n));
    Binding<Real> binding;
    const bool bound = load_nodes(forward.set, n, binding);
    std::copy_n(args.carried->weights.data() + n * kBindings, kBindings, binding.weight);
    CarriedGradient<Real> out;
    Real d_weight[kBindings] = {};
    for (int64_t b = 0; b < int64_t(forward.batch->views.size()); ++b) {
      const CarriedGaussian<Real>& d = args.d_carried[b * count + n];
      if (!bound) {
        out.mean += d.mean;
        out.rotation += d.rotation;
        continue;
      }
      const NodePose<Real>* const poses = args.carried->poses.data() + b * nodes;
      const Carry<Real> carry = blend_poses(binding, poses);
      const CarryGradient<Real> gradient =
          carry_backward(binding, poses, carry, mean, rotation, d.mean, d.rotation);
      out.mean += gradient.mean;
      out.rotation += gradient.rotation;
      for (int k = 0; k < kBindings; ++k) {
        if (binding.node[k] < 0) continue;
        d_weight[k] += gradient.weight[k];
        add_to(sums.pose[size_t(b * nodes + binding.node[k])],
               node_share(binding.weight[k], carry.flipped[k], mean, d.mean, gradient.turn));
      }
    }
    if (!bound) return out;
    binding_weights_backward(binding, d_weight, out.node_logit);
    const NodeDistances<Real> distances = node_distances(forward.nodes, mean, binding);
    for (int k = 0; k < kBindings; ++k)
      if (binding.node[k] >= 0)
        sums.falloff[size_t(binding.node[k])] -= distances.distance2[k] * out.node_logit[k];
    return out;
  }
};

/// Whether any view has a gradient for Gaussian n.
template <class Real>
bool has_gradient(const CarryBackwardArgs<Real>& args, int64_t n) {
  const Vec3<Real> none3(Real(0));
  const Vec4<Real> none4(Real(0));
  for (int64_t i = n; i < args.d_carried.size; i += args.forward.set.count)
    if (args.d_carried[i].mean != none3 || args.d_carried[i].rotation != none4) return true;
  return false;
}

/// The sums of all Gaussians; the gradients of each go into the sink.
template <class Real>
NodeSums<Real> gather_gradients(const CarryBackwardArgs<Real>& args, std::atomic<unsigned>& bad) {
  const int64_t count = args.forward.set.count, nodes = args.forward.nodes.count;
  const size_t views = args.forward.batch->views.size();
  const int64_t part = std::max(kGrain, (count + kParts - 1) / kParts);
  std::vector<NodeSums<Real>> parts(size_t((count + part - 1) / part));
  const IdleUpdate idle = args.sink.fused ? args.sink.idle : IdleUpdate::kDense;
  parallel_for(int64_t(parts.size()), 1, [&](int64_t p, int64_t) {
    NodeSums<Real>& sums = parts[size_t(p)];
    sums = zero_sums<Real>(views, nodes);
    for (int64_t n = p * part; n < std::min(count, (p + 1) * part); ++n) {
      if (idle == IdleUpdate::kSkip && !has_gradient(args, n)) continue;
      const CarriedGradient<Real> gradient = ElementBackward<Real>{args}(n, sums);
      bad |= non_finite_groups<SetForm::kCanonical>(gradient);
      if (args.sink.fused)
        ApplyAdam<Real>{args.sink.value, args.sink.moment1, args.sink.moment2, args.sink.adam}
            .template accept<SetForm::kCanonical>(n, gradient);
      else
        StoreGradient<Real>{args.sink.gradient}.template accept<SetForm::kCanonical>(n, gradient);
    }
  });
  NodeSums<Real> all = zero_sums<Real>(views, nodes);
  for (const NodeSums<Real>& sums : parts) {
    for (size_t i = 0; i < all.pose.size(); ++i) add_to(all.pose[i], sums.pose[i]);
    for (size_t m = 0; m < all.falloff.size(); ++m) all.falloff[m] += sums.falloff[m];
  }
  return all;
}

template <class Real>
void check_args(const CarryArgs<Real>& args) {
  check(args.set.form == SetForm::kCanonical, "carry: a canonical set");
  check(args.nodes.knots >= kSplineOrder || args.nodes.count == 0, "carry: too few control points");
}

}  // namespace

template <class Real>
void CpuBackend<Real>::carry(const CarryArgs<Real>& args, Carried<Real>& carried) {
  check_args(args);
  const NodeSpans<const Real>& nodes = args.nodes;
  const std::vector<ViewArgs<Real>>& views = args.batch->views;
  const int64_t count = args.set.count;
  carried.poses.resize(int64_t(views.size()) * nodes.count);
  carried.weights.resize(count * kBindings);
  carried.gaussians.resize(int64_t(views.size()) * count);
  for (size_t b = 0; b < views.size(); ++b) {
    const SplineWeights<Real> s =
        spline_weights(views[b].time, std::max(nodes.knots, kSplineOrder));
    for (int64_t m = 0; m < nodes.count; ++m)
      carried.poses[int64_t(b) * nodes.count + m] = node_pose(
          load3(nodes.position.data + 3 * m), s, translation_of(nodes, m), rotation_of(nodes, m));
  }
  parallel_for(count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      const Vec3<Real> mean = load3(args.set.at(kMean, n));
      const Vec4<Real> rotation = load4(args.set.at(kRotation, n));
      Binding<Real> binding;
      const bool bound = load_nodes(args.set, n, binding);
      const NodeDistances<Real> d = node_distances(nodes, mean, binding);
      binding_weights(args.set.at(kNodeLogit, n), d.falloff, d.distance2, binding);
      std::copy_n(binding.weight, kBindings, carried.weights.data() + n * kBindings);
      for (int64_t b = 0; b < int64_t(views.size()); ++b)
        carried.gaussians[b * count + n] =
            carried_in_view(bound, binding, carried.poses.data() + b * nodes.count, mean, rotation);
    }
  });
}

template <class Real>
void CpuBackend<Real>::carry_backward(const CarryBackwardArgs<Real>& args) {
  check_args(args.forward);
  check(args.d_carried.size == int64_t(args.forward.batch->views.size()) * args.forward.set.count,
        "carry_backward: one gradient a view and Gaussian");
  std::atomic<unsigned> bad{0};
  const NodeSums<Real> sums = gather_gradients(args, bad);
  outcome_.bad_groups |= bad;
  const std::vector<ViewArgs<Real>>& views = args.forward.batch->views;
  for (int64_t m = 0; m < args.forward.nodes.count; ++m)
    write_node_gradient(args.forward.nodes, m, views.data(), int(views.size()), sums.pose.data(),
                        sums.falloff[size_t(m)], args.acceleration, args.d_nodes);
}

template void CpuBackend<float>::carry(const CarryArgs<float>&, Carried<float>&);
template void CpuBackend<double>::carry(const CarryArgs<double>&, Carried<double>&);
template void CpuBackend<float>::carry_backward(const CarryBackwardArgs<float>&);
template void CpuBackend<double>::carry_backward(const CarryBackwardArgs<double>&);

}  // namespace tessera
