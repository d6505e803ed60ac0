// What: the stages of a training step for a batch of views. A backend is a traversal of math/.
// Not: the order of the stages (recon4d/renderer.h) and no parameters' ownership.
// CpuBackend is here in float (the working path) and double (the oracle); CUDA is float only.
#pragma once
#include <memory>
#include <string>

#include "kernels/batch.h"
#include "kernels/gaussians.h"

namespace tessera {

template <class Real>
struct ProjectArgs {
  const ViewBatch<Real>* batch = nullptr;
  GaussianSpans<const Real> sets[2];  // static, dynamic; either may be empty
  RenderOptions options;
};

template <class Real>
struct BlendArgs {
  const ViewBatch<Real>* batch = nullptr;
  const Splats<Real>* splats = nullptr;
  const TileInstances<Real>* instances = nullptr;
  RenderOptions options;
};

template <class Real>
struct PhotometricArgs {
  const ViewBatch<Real>* batch = nullptr;
  const Images<Real>* images = nullptr;
  std::vector<Span<const uint8_t>> truth;  // [B] each [height, width, 3]
  LossWeights weights;
};

template <class Real>
struct BlendBackwardArgs {
  BlendArgs<Real> forward;
  const Images<Real>* images = nullptr;
  Span<const Real> d_colour;  // [3·pixels], laid out as Images::colour
};

template <class Real>
struct ProjectBackwardArgs {
  ProjectArgs<Real> forward;
  const Splats<Real>* splats = nullptr;
  Span<const SplatGradient<Real>> d_splats;  // [S]
  SinkArgs<Real> sinks[2];
  DensityStatistics<Real> statistics[2];  // empty spans: not gathered
};

template <class Real>
class BackendOf {
 public:
  virtual ~BackendOf() = default;
  virtual std::string name() const = 0;  // "cpu, 2 threads"
  virtual Memory& memory() = 0;

  /// Gaussians → visible splats of every view: slice, EWA, colour, tiles counted.
  virtual void project(const ProjectArgs<Real>& args, Splats<Real>& splats) = 0;
  /// Splats → instances by tile and depth. `for_backward` also fills TileInstances::slot.
  virtual void bin(const ViewBatch<Real>& batch, const Splats<Real>& splats, bool for_backward,
                   TileInstances<Real>& instances) = 0;
  /// Front-to-back blending of every tile.
  virtual void blend(const BlendArgs<Real>& args, Images<Real>& images) = 0;
  /// Loss of each view, and d_colour of its mean over the batch (empty: not wanted).
  virtual std::vector<ViewLoss> photometric(const PhotometricArgs<Real>& args,
                                            Span<Real> d_colour) = 0;
  /// Gradient of each splat, summed over its pixels.
  virtual void blend_backward(const BlendBackwardArgs<Real>& args,
                              Span<SplatGradient<Real>> d_splats) = 0;
  /// Splat gradients → parameter gradients, summed over views, into the sinks. Returns a bit per
  /// group (1 << Group) in which a non-finite gradient was met.
  virtual unsigned project_backward(const ProjectBackwardArgs<Real>& args) = 0;
  /// Adam over stored gradients: what the fused sink does, as a stage of its own.
  virtual void adam(const SinkArgs<Real>& args) = 0;
  /// to[i] = from[index[i]] for rows of `width` scalars; index −1 writes zeros.
  virtual void gather_rows(Span<const Real> from, Span<const int64_t> index, int width,
                           Span<Real> to) = 0;
};

using Backend = BackendOf<float>;

std::unique_ptr<Backend> make_cpu_backend();
std::unique_ptr<BackendOf<double>> make_oracle_backend();
/// Errors: DeviceError when this build or machine has no CUDA device.
std::unique_ptr<Backend> make_cuda_backend();

}  // namespace tessera
