// Canonical Gaussians carried by motion nodes on the device, and the backward pass. Sums over the
// Gaussians of a node run over a list of bindings that is sorted by node, in a fixed order and
// without atomics: equal inputs give equal bits. The file is compiled without contraction, so that
// a Gaussian without nodes stays as it is stored. Equations: kernels/math/carry.h, node_pose.h.
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_memory.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/sort.h"
#include "kernels/stages/accept_block.cuh"
#include "kernels/stages/carry.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;
constexpr int kPoseFloats = int(sizeof(NodePose<float>) / sizeof(float));  // 16

struct Carrying {
  GaussianSpans<const float> set;
  NodeSpans<const float> nodes;
  const ViewArgs<float>* views;
  int view_count;
};

__global__ void pose_nodes(Carrying a, NodePose<float>* poses) {
  const int64_t i = linear_index();
  if (i >= a.view_count * a.nodes.count) return;
  const int64_t m = i % a.nodes.count;
  poses[i] = node_pose(load3(a.nodes.position.data + 3 * m),
                       spline_weights(a.views[i / a.nodes.count].time, a.nodes.knots),
                       translation_of(a.nodes, m), rotation_of(a.nodes, m));
}

__global__ void __launch_bounds__(kThreads)
    carry_gaussians(Carrying a, const NodePose<float>* poses, float* weights,
                    CarriedGaussian<float>* gaussians) {
  const int64_t n = linear_index();
  if (n >= a.set.count) return;
  const Vec3<float> mean = load3(a.set.at(kMean, n));
  const Vec4<float> rotation = load4(a.set.at(kRotation, n));
  Binding<float> binding;
  const bool bound = load_nodes(a.set, n, binding);
  const NodeDistances<float> d = node_distances(a.nodes, mean, binding);
  binding_weights(a.set.at(kNodeLogit, n), d.falloff, d.distance2, binding);
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) weights[n * kBindings + k] = binding.weight[k];
  for (int b = 0; b < a.view_count; ++b)
    gaussians[b * a.set.count + n] =
        carried_in_view(bound, binding, poses + b * a.nodes.count, mean, rotation);
}

/// What the gradients of Gaussians leave for those of nodes.
struct Shares {
  const NodePose<float>* poses;             // [B, M]
  const float* weights;                     // [N, kBindings]
  const CarriedGaussian<float>* d_carried;  // [B, N]
  float4* rest;                             // [N] mean before it takes its step
  Vec4<float>* d_turn;                      // [B, N]
  uint8_t* flipped;                         // [B, N] a bit a binding
  float* d_falloff;                         // [N, kBindings]
};

/// Gradient of Gaussian n at rest.
__device__ inline CarriedGradient<float> gradient_at_rest(const Carrying& a, const Shares& shares,
                                                          int64_t n, bool& any) {
  const Vec3<float> mean = load3(a.set.at(kMean, n));
  const Vec4<float> rotation = load4(a.set.at(kRotation, n));
  Binding<float> binding;
  const bool bound = load_nodes(a.set, n, binding);
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k) binding.weight[k] = shares.weights[n * kBindings + k];
  CarriedGradient<float> out;
  float d_weight[kBindings] = {};
  any = false;
  for (int b = 0; b < a.view_count; ++b) {
    const int64_t place = b * a.set.count + n;
    const CarriedGaussian<float> d = shares.d_carried[place];
    any = any || d.mean != Vec3<float>(0.0f) || d.rotation != Vec4<float>(0.0f);
    if (!bound) {
      out.mean += d.mean;
      out.rotation += d.rotation;
      continue;
    }
    const NodePose<float>* const poses = shares.poses + b * a.nodes.count;
    const Carry<float> carry = blend_poses(binding, poses);
    const CarryGradient<float> gradient =
        carry_backward(binding, poses, carry, mean, rotation, d.mean, d.rotation);
    out.mean += gradient.mean;
    out.rotation += gradient.rotation;
    unsigned flipped = 0;
    TESSERA_UNROLL
    for (int k = 0; k < kBindings; ++k) {
      d_weight[k] += gradient.weight[k];
      flipped |= unsigned(carry.flipped[k]) << k;
    }
    shares.d_turn[place] = gradient.turn;
    shares.flipped[place] = uint8_t(flipped);
  }
  shares.rest[n] = {mean[0], mean[1], mean[2], 0};
  if (!bound) return out;
  binding_weights_backward(binding, d_weight, out.node_logit);
  const NodeDistances<float> distances = node_distances(a.nodes, mean, binding);
  TESSERA_UNROLL
  for (int k = 0; k < kBindings; ++k)
    shares.d_falloff[n * kBindings + k] = -distances.distance2[k] * out.node_logit[k];
  return out;
}

template <class Sink>
__global__ void __launch_bounds__(kThreads)
    carry_elements_backward(Carrying a, Shares shares, Sink sink, IdleUpdate idle,
                            StepCounters* counters) {
  __shared__ float gradients[15 * kThreads];
  __shared__ bool stepping[kThreads];
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  CarriedGradient<float> gradient;
  bool on = n < a.set.count;
  if (on) {
    bool any;
    gradient = gradient_at_rest(a, shares, n, any);
    on = any || idle != IdleUpdate::kSkip;
    const unsigned bad = non_finite_groups<SetForm::kCanonical>(gradient);
    if (bad != 0) atomicOr(&counters->bad_groups, bad);
  }
  accept_block<SetForm::kCanonical, kThreads>(sink, a.set.count, on, gradient, gradients, stepping);
}

/// Node of each binding; `nodes`: none.
__global__ void list_bindings(const float* node, int64_t bindings, int nodes, uint16_t* keys,
                              int32_t* values) {
  const int64_t i = linear_index();
  if (i >= bindings) return;
  keys[i] = node[i] < 0 ? uint16_t(nodes) : uint16_t(int(node[i]));
  values[i] = int32_t(i);
}

/// begin[m]: the first of the sorted bindings of node m; begin[nodes]: the first of none.
__global__ void find_begins(const uint16_t* sorted, int64_t bindings, int nodes, int32_t* begin) {
  const int64_t i = linear_index();
  if (i > bindings) return;
  const int before = i == 0 ? -1 : int(sorted[i - 1]);
  const int now = i == bindings ? nodes : int(sorted[i]);
  for (int m = before + 1; m <= now; ++m) begin[m] = int32_t(i);
}

/// Over the lanes of a block; in thread 0.
template <int Terms>
__device__ inline void sum_block(float (&v)[Terms]) {
  __shared__ float parts[kThreads / 32][Terms];
  const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
  TESSERA_UNROLL
  for (int j = 0; j < Terms; ++j) {
    TESSERA_UNROLL
    for (int step = 16; step > 0; step /= 2) v[j] += __shfl_down_sync(~0u, v[j], step);
    if (lane == 0) parts[warp][j] = v[j];
  }
  __syncthreads();
  if (threadIdx.x != 0) return;
  TESSERA_UNROLL
  for (int j = 0; j < Terms; ++j)
    for (int w = 1; w < kThreads / 32; ++w) v[j] += parts[w][j];
}

/// A block for each node and view: the gradient of its pose; behind the views one for its ι.
__global__ void __launch_bounds__(kThreads)
    sum_nodes(Carrying a, Shares shares, const int32_t* begin, const int32_t* binding,
              NodePose<float>* d_poses, float* d_falloff) {
  const int m = int(blockIdx.x), b = int(blockIdx.y);
  const int first = begin[m] + int(threadIdx.x), last = begin[m + 1];
  if (b == a.view_count) {
    float sum[1] = {0};
    for (int i = first; i < last; i += kThreads) sum[0] += shares.d_falloff[binding[i]];
    sum_block(sum);
    if (threadIdx.x == 0) d_falloff[m] = sum[0];
    return;
  }
  float sum[kPoseFloats] = {};
  for (int i = first; i < last; i += kThreads) {
    const int64_t n = binding[i] / kBindings, place = b * a.set.count + n;
    const float4 rest = shares.rest[n];
    const bool flipped = shares.flipped[place] >> (binding[i] % kBindings) & 1;
    const NodePose<float> share =
        node_share(shares.weights[binding[i]], flipped, Vec3<float>(rest.x, rest.y, rest.z),
                   shares.d_carried[place].mean, shares.d_turn[place]);
    TESSERA_UNROLL
    for (int j = 0; j < kPoseFloats; ++j) sum[j] += reinterpret_cast<const float*>(&share)[j];
  }
  sum_block(sum);
  if (threadIdx.x != 0) return;
  TESSERA_UNROLL
  for (int j = 0; j < kPoseFloats; ++j)
    reinterpret_cast<float*>(d_poses + b * a.nodes.count + m)[j] = sum[j];
}

__global__ void write_nodes(Carrying a, const NodePose<float>* d_poses, const float* d_falloff,
                            float acceleration, NodeSpans<float> d_nodes) {
  const int64_t m = linear_index();
  if (m < a.nodes.count)
    write_node_gradient(a.nodes, m, a.views, a.view_count, d_poses, d_falloff[m], acceleration,
                        d_nodes);
}

void check_args(const CarryArgs<float>& args) {
  check(args.set.form == SetForm::kCanonical, "carry: a canonical set");
  check(args.nodes.knots >= kSplineOrder || args.nodes.count == 0, "carry: too few control points");
}

}  // namespace

void CudaBackend::carry(const CarryArgs<float>& args, Carried<float>& carried) {
  check_args(args);
  const Carrying a{args.set, args.nodes, views_of(*args.batch), int(args.batch->views.size())};
  carried.poses.resize(a.view_count * args.nodes.count);
  carried.weights.resize(args.set.count * kBindings);
  carried.gaussians.resize(a.view_count * args.set.count);
  launch_linear<64>(stream_, "carry: pose_nodes", pose_nodes, carried.poses.size(), a,
                    carried.poses.data());
  launch_linear<kThreads>(stream_, "carry: carry_gaussians", carry_gaussians, args.set.count, a,
                          std::as_const(carried).poses.data(), carried.weights.data(),
                          carried.gaussians.data());
}

void CudaBackend::carry_backward(const CarryBackwardArgs<float>& args) {
  const CarryArgs<float>& forward = args.forward;
  check_args(forward);
  const int64_t count = forward.set.count, nodes = forward.nodes.count;
  const Carrying a{forward.set, forward.nodes, views_of(*forward.batch),
                   int(forward.batch->views.size())};
  check(args.d_carried.size == a.view_count * count,
        "carry_backward: one gradient a view and Gaussian");
  const int64_t drawn = a.view_count * count, bindings = count * kBindings;
  Scratch scratch(scratch_);
  scratch.plan<float4>(count);
  scratch.plan<Vec4<float>>(drawn);
  scratch.plan<uint8_t>(drawn);
  scratch.plan<float>(bindings);
  scratch.plan<NodePose<float>>(a.view_count * nodes);
  scratch.plan<float>(nodes);
  for (int k = 0; k < 2; ++k) {
    scratch.plan<uint16_t>(bindings);
    scratch.plan<int32_t>(bindings);
  }
  scratch.plan<int32_t>(nodes + 1);
  scratch.allocate();
  Shares shares{args.carried->poses.data(), args.carried->weights.data(), args.d_carried.data};
  shares.rest = scratch.take<float4>(count).data;
  shares.d_turn = scratch.take<Vec4<float>>(drawn).data;
  shares.flipped = scratch.take<uint8_t>(drawn).data;
  shares.d_falloff = scratch.take<float>(bindings).data;
  NodePose<float>* const d_poses = scratch.take<NodePose<float>>(a.view_count * nodes).data;
  float* const d_falloff = scratch.take<float>(nodes).data;
  const auto keys = scratch.take<uint16_t>(bindings);
  const auto values = scratch.take<int32_t>(bindings);
  const auto sorted_keys = scratch.take<uint16_t>(bindings);
  const auto sorted = scratch.take<int32_t>(bindings);
  const auto begin = scratch.take<int32_t>(nodes + 1);

  const auto run = [&](const auto& sink) {
    if (count == 0) return;
    carry_elements_backward<<<grid_of(count, kThreads), kThreads, 0, stream_>>>(
        a, shares, sink, args.sink.fused ? args.sink.idle : IdleUpdate::kDense, counters_.data());
    check_launch("carry_backward: elements");
  };
  if (args.sink.fused)
    run(ApplyAdam<float>{args.sink.value, args.sink.moment1, args.sink.moment2, args.sink.adam});
  else
    run(StoreGradient<float>{args.sink.gradient});
  report();
  if (nodes == 0) return;
  launch_linear<kThreads>(stream_, "carry_backward: list_bindings", list_bindings, bindings,
                          forward.set.group[kNode].data, bindings, int(nodes), keys.data,
                          values.data);
  sort_pairs(stream_, {keys.data, bindings}, {values.data, bindings}, bits_of(nodes + 1),
             sorted_keys, sorted, sort_scratch_);
  launch_linear<kThreads>(stream_, "carry_backward: find_begins", find_begins, bindings + 1,
                          sorted_keys.data, bindings, int(nodes), begin.data);
  sum_nodes<<<dim3(unsigned(nodes), unsigned(a.view_count + 1)), kThreads, 0, stream_>>>(
      a, shares, begin.data, sorted.data, d_poses, d_falloff);
  check_launch("carry_backward: sum_nodes");
  launch_linear<32>(stream_, "carry_backward: write_nodes", write_nodes, nodes, a, d_poses,
                    d_falloff, args.acceleration, args.d_nodes);
}

}  // namespace tessera
