// Motion nodes as kernels see them, and what they make of a canonical set in the views of a batch.
// The equations are in math/node_pose.h and math/carry.h (method D.9).
#pragma once
#include "kernels/batch.h"
#include "kernels/gaussians.h"

namespace tessera {

/// M nodes with S control points each.
template <class T>
struct NodeSpans {
  int64_t count = 0;    // M; 0: none
  int knots = 0;        // S, at least kSplineOrder
  Span<T> position;     // [M, 3] world units, at rest; not optimised
  Span<T> log_radius;   // [M] ln of world units
  Span<T> translation;  // [M, S, 3] world units
  Span<T> rotation;     // [M, S, 4] quaternion w,x,y,z before its blend is normalised
};

/// What `carry` leaves for the stages behind it.
template <class Real>
struct Carried {
  explicit Carried(Memory& memory = host_memory())
      : poses(memory), weights(memory), gaussians(memory) {}

  Buffer<NodePose<Real>> poses;             // [B, M]
  Buffer<Real> weights;                     // [N, kBindings]
  Buffer<CarriedGaussian<Real>> gaussians;  // [B, N]
};

template <class Real>
struct CarryArgs {
  const ViewBatch<Real>* batch = nullptr;
  GaussianSpans<const Real> set;  // canonical; its `carried` is not read
  NodeSpans<const Real> nodes;
};

template <class Real>
struct CarryBackwardArgs {
  CarryArgs<Real> forward;
  const Carried<Real>* carried = nullptr;
  Span<const CarriedGaussian<Real>> d_carried;  // [B, N] of project_backward
  SinkArgs<Real> sink;          // of mean, rotation and node_logit; what else it has is not touched
  NodeSpans<Real> d_nodes;      // written but for `position`
  Real acceleration = Real(0);  // weight of Σ over nodes ‖second differences of translation‖²
};

}  // namespace tessera
