// The order of the stages for a batch of views, and the buffers between them. Parameters come in as
// spans and gradients leave through sinks. Trainer, evaluation, export and the double-precision
// tests all render through this class.
#pragma once
#include <vector>

#include "kernels/backend.h"

namespace tessera {

/// Ground truth of a batch and how it is compared.
struct Target {
  std::vector<Span<const uint8_t>> truth;  // [B] each [height, width, 3]
  LossWeights weights;
  std::vector<Span<const uint8_t>> mask;     // as PhotometricArgs::mask
  std::vector<ColourMap<double>> maps = {};  // [B] of the images before they are compared
};

template <class Real>
struct BackwardArgs {
  SinkArgs<Real> sinks[2];
  DensityStatistics<Real> statistics[2];
  RegulariserWeights regulariser;
  Span<Real> d_environment = {};  // [H, 2H, 3] written where the forward pass had an environment
  NodeSpans<Real> d_nodes = {};   // written where it had nodes
  Real acceleration = Real(0);    // as CarryBackwardArgs::acceleration
  bool by_time = false;           // as ProjectBackwardArgs::by_time
};

/// Gaussians, views and how they are drawn.
template <class Real>
struct ForwardArgs {
  GaussianSpans<const Real> sets[2];  // static, dynamic
  std::vector<View> views;
  RenderOptions options;
  bool for_backward = false;
  EnvironmentArgs<Real> environment = {};  // its batch is the pipeline's
  NodeSpans<const Real> nodes = {};        // of a canonical static set
};

/// What a step found, besides the images.
struct PipelineReport {
  int64_t splats = 0, instances = 0, invalid_gaussians = 0;
};

template <class Real>
class Pipeline {
 public:
  explicit Pipeline(BackendOf<Real>& backend)
      : backend_(backend),
        splats_(backend.memory()),
        instances_(backend.memory()),
        images_(backend.memory()),
        mapped_(backend.memory()),
        d_colour_(backend.memory()),
        d_splats_(backend.memory()),
        lengths_(backend.memory()),
        carried_(backend.memory()),
        d_carried_(backend.memory()),
        sensitivity_(backend.memory()) {}
  Pipeline(const Pipeline&) = delete;  // what is kept of a forward pass points into its members
  Pipeline& operator=(const Pipeline&) = delete;

  /// project → bin → blend → environment. The images stay valid until the next call.
  const Images<Real>& forward(const ForwardArgs<Real>& args);
  const Images<Real>& forward(const GaussianSpans<const Real>& static_set,
                              const GaussianSpans<const Real>& dynamic_set,
                              const std::vector<View>& views, const RenderOptions& options,
                              bool for_backward = false) {
    return forward({{static_set, dynamic_set}, views, options, for_backward});
  }
  /// Loss of each view of the last forward, un-divided by B; `outcome` has it.
  void loss(const Target& target, bool for_backward = false);
  /// blend_backward → project_backward of the mean loss over the batch. Needs forward and loss
  /// with for_backward.
  void backward(const BackwardArgs<Real>& args);
  /// What the images of the last forward miss of their truth → d_colour(). The weights are not
  /// used.
  void residual(const Target& target);
  /// What each splat of the last forward, which was for_backward, is to the images, with
  /// d_colour() for the image x: that of `residual`, whose masks and maps it also takes, or any
  /// that was written there. [S] in the backend's memory, valid until the next call.
  Span<const SplatSensitivity<Real>> sensitivity();
  /// Adds the splats of the last forward, with the sums that the last sensitivity found, to their
  /// Gaussians: `elements` [N] static set first, `variation` [N of the static set] or empty.
  void add_contributions(Span<ElementSums<Real>> elements, Span<TimeVariation> variation = {});
  /// Raises the value of each Gaussian, [N] static set first, to its largest blending weight in the
  /// images of the last forward, which was for_backward.
  void add_largest_weights(Span<Real> elements);
  /// Gives the memory of the last step back, so that something else can have it for a while.
  void release();
  /// Losses and non-finite gradients of the last loss and backward. On a device the wait is short
  /// when the next forward has been called already.
  StepOutcome outcome() { return backend_.outcome(); }

  const ViewBatch<Real>& batch() const { return batch_; }
  const Splats<Real>& splats() const { return splats_; }
  const TileInstances<Real>& instances() const { return instances_; }
  /// dL/d image of the last loss; tests write to it to send any gradient backward.
  Buffer<Real>& d_colour() { return d_colour_; }
  PipelineReport report() const { return {splats_.count, instances_.count, splats_.invalid}; }

 private:
  /// The images of the last forward with their colours mapped, where the target has maps.
  PhotometricArgs<Real> compared(const Target& target);
  BlendArgs<Real> blend_args() const {
    return {&batch_, &splats_, &instances_, project_.options, project_.for_backward};
  }

  BackendOf<Real>& backend_;
  ViewBatch<Real> batch_;
  ProjectArgs<Real> project_;
  EnvironmentArgs<Real> environment_;
  Splats<Real> splats_;
  TileInstances<Real> instances_;
  Images<Real> images_;
  Buffer<Real> mapped_;  // images_ as their cameras would have taken them
  Buffer<Real> d_colour_;
  Buffer<SplatMoments<Real>> d_splats_;
  Buffer<Real> lengths_;         // [S] or empty
  NodeSpans<const Real> nodes_;  // of the last forward with a canonical set
  Carried<Real> carried_;
  Buffer<CarriedGaussian<Real>> d_carried_;  // [B, N]
  Target compared_;                          // of the last residual
  Buffer<SplatSensitivity<Real>> sensitivity_;
};

}  // namespace tessera
