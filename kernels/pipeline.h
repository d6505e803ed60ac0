// What: the order of the stages for a batch of views, and the buffers between them.
// Not: a model or a schedule: parameters come in as spans, gradients leave through sinks.
// Trainer, evaluation, export and the double-precision tests all render through this class.
#pragma once
#include <array>

#include "kernels/backend.h"

namespace tessera {

/// Ground truth of a batch and how it is compared.
struct Target {
  std::vector<Span<const uint8_t>> truth;  // [B] each [height, width, 3]
  LossWeights weights;
};

template <class Real>
struct BackwardArgs {
  SinkArgs<Real> sinks[2];
  DensityStatistics<Real> statistics[2];
};

/// Wall time of each stage since construction, seconds. On the CPU a stage ends when it returns.
enum Stage : int {
  kProject,
  kBin,
  kBlend,
  kPhotometric,
  kBlendBackward,
  kProjectBackward,
  kStages
};
inline constexpr const char* kStageNames[kStages] = {
    "project", "bin", "blend", "photometric", "blend_backward", "project_backward"};

/// What a step found, besides the pictures.
struct PipelineReport {
  int64_t splats = 0, instances = 0, invalid_gaussians = 0;
};

template <class Real>
class Pipeline {
 public:
  explicit Pipeline(BackendOf<Real>& backend) : backend_(backend) {}

  /// project → bin → blend. The pictures stay valid until the next call.
  const Images<Real>& forward(const GaussianSpans<const Real>& static_set,
                              const GaussianSpans<const Real>& dynamic_set,
                              const std::vector<View>& views, const RenderOptions& options,
                              bool for_backward = false);
  /// Loss of each view of the last forward, un-divided by B.
  std::vector<ViewLoss> loss(const Target& target, bool for_backward = false);
  /// blend_backward → project_backward of the mean loss over the batch. Needs forward and loss
  /// with for_backward. Returns a bit (1 << Group) per group with a non-finite gradient.
  unsigned backward(const BackwardArgs<Real>& args);

  const ViewBatch<Real>& batch() const { return batch_; }
  const Splats<Real>& splats() const { return splats_; }
  const TileInstances<Real>& instances() const { return instances_; }
  /// dL/d picture of the last loss; tests write to it to send any gradient backward.
  Buffer<Real>& d_colour() { return d_colour_; }
  const std::array<double, kStages>& stage_seconds() const { return stage_seconds_; }
  PipelineReport report() const { return {splats_.count, instances_.count, splats_.invalid}; }

 private:
  BackendOf<Real>& backend_;
  ViewBatch<Real> batch_;
  ProjectArgs<Real> project_;
  Splats<Real> splats_;
  TileInstances<Real> instances_;
  Images<Real> images_;
  Buffer<Real> d_colour_;
  Buffer<SplatGradient<Real>> d_splats_;
  std::array<double, kStages> stage_seconds_{};
};

}  // namespace tessera
