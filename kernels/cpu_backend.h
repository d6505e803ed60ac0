// What: the CPU traversal of every stage, in float (working path) and double (oracle).
// Not: equations; those are in math/. Each stage is defined in stages/<stage>.cpp.
#pragma once
#include "kernels/backend.h"

namespace tessera {

template <class Real>
class CpuBackend final : public BackendOf<Real> {
 public:
  std::string name() const override;
  Memory& memory() override { return host_memory(); }
  void project(const ProjectArgs<Real>& args, Splats<Real>& splats) override;
  void bin(const ViewBatch<Real>& batch, const Splats<Real>& splats, bool for_backward,
           TileInstances<Real>& instances) override;
  void blend(const BlendArgs<Real>& args, Images<Real>& images) override;
  std::vector<ViewLoss> photometric(const PhotometricArgs<Real>& args,
                                    Span<Real> d_colour) override;
  void blend_backward(const BlendBackwardArgs<Real>& args,
                      Span<SplatGradient<Real>> d_splats) override;
  unsigned project_backward(const ProjectBackwardArgs<Real>& args) override;
  void adam(const SinkArgs<Real>& args) override;
  void gather_rows(Span<const Real> from, Span<const int64_t> index, int width,
                   Span<Real> to) override;

 private:
  Buffer<SplatGradient<Real>> instance_gradients_;  // [I] by slot, summed per splat in order
};

}  // namespace tessera
