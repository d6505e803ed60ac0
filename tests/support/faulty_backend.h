// What: the CPU backend with one value spoilt at one step: what a broken kernel or frame would do.
// Not: a mock: every stage runs as it is.
#pragma once
#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "kernels/backend.h"

namespace tessera::testing {

/// Where the NaN goes: into the gradient of the first splat, or into the loss of the first view.
enum class Fault { kMean2d, kConic, kOpacity, kColour, kLoss };

class FaultyBackend final : public Backend {
 public:
  /// `step`: counted from 1, as StepReport::iteration.
  FaultyBackend(Fault fault, int64_t step) : fault_(fault), step_(step) {}

  std::string name() const override { return "faulty " + cpu_->name(); }
  Memory& memory() override { return cpu_->memory(); }
  void project(const ProjectArgs<float>& args, Splats<float>& splats) override {
    ++steps_begun_;
    cpu_->project(args, splats);
  }
  void bin(const ViewBatch<float>& batch, const Splats<float>& splats, bool for_backward,
           TileInstances<float>& instances) override {
    cpu_->bin(batch, splats, for_backward, instances);
  }
  void blend(const BlendArgs<float>& args, Images<float>& images) override {
    cpu_->blend(args, images);
  }
  std::vector<ViewLoss> photometric(const PhotometricArgs<float>& args,
                                    Span<float> d_colour) override {
    std::vector<ViewLoss> losses = cpu_->photometric(args, d_colour);
    if (strikes(Fault::kLoss)) losses[0].total = kNan;
    return losses;
  }
  void blend_backward(const BlendBackwardArgs<float>& args,
                      Span<SplatGradient<float>> d_splats) override {
    cpu_->blend_backward(args, d_splats);
    if (d_splats.empty()) return;
    if (strikes(Fault::kMean2d)) d_splats[0].mean2d[0] = kNan;
    if (strikes(Fault::kConic)) d_splats[0].conic.xx = kNan;
    if (strikes(Fault::kOpacity)) d_splats[0].opacity = kNan;
    if (strikes(Fault::kColour)) d_splats[0].colour[1] = kNan;
  }
  unsigned project_backward(const ProjectBackwardArgs<float>& args) override {
    return cpu_->project_backward(args);
  }
  void adam(const SinkArgs<float>& args) override { cpu_->adam(args); }
  void gather_rows(Span<const float> from, Span<const int64_t> index, int width,
                   Span<float> to) override {
    cpu_->gather_rows(from, index, width, to);
  }

 private:
  static constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  bool strikes(Fault fault) const { return fault == fault_ && steps_begun_ == step_; }

  std::unique_ptr<Backend> cpu_ = make_cpu_backend();
  Fault fault_;
  int64_t step_, steps_begun_ = 0;
};

}  // namespace tessera::testing
