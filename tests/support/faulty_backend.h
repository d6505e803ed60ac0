// The CPU backend with one value changed at one step, as by a faulty kernel or frame.
#pragma once
#include <limits>
#include <memory>

#include "kernels/backend.h"

namespace tessera::testing {

/// Where the NaN goes: into the gradient of the first splat, into that of the first texel of the
/// environment, or into the loss of the first view.
enum class Fault { kMean2d, kConic, kOpacity, kColour, kTexel, kLoss };

/// Whose operations are those of the CPU.
class ForwardingBackend : public Backend {
 public:
  using Real = float;
  std::string name() const override { return "forwarding " + cpu_->name(); }
  Memory& memory() override { return cpu_->memory(); }
  StageClock& clock() override { return cpu_->clock(); }
#define OPERATION(result, name, parameters, names) \
  result name parameters override {                \
    return cpu_->name names;                       \
  }
#include "kernels/operations.inc"

 private:
  std::unique_ptr<Backend> cpu_ = make_cpu_backend();
};

class FaultyBackend final : public ForwardingBackend {
 public:
  /// `step`: counted from 1, as StepReport::iteration.
  FaultyBackend(Fault fault, int64_t step) : fault_(fault), step_(step) {}

  void project(const ProjectArgs<float>& args, Splats<float>& splats) override {
    ++steps_begun_;
    ForwardingBackend::project(args, splats);
  }
  void environment_backward(const EnvironmentArgs<float>& args, const Images<float>& images,
                            Span<const float> d_colour, Span<float> d_map) override {
    ForwardingBackend::environment_backward(args, images, d_colour, d_map);
    if (strikes(Fault::kTexel)) d_map[0] = kNan;
  }
  void photometric(const PhotometricArgs<float>& args, Span<float> d_colour) override {
    ForwardingBackend::photometric(args, d_colour);
    loss_is_spoilt_ = strikes(Fault::kLoss);
  }
  void blend_backward(const BlendBackwardArgs<float>& args,
                      Span<SplatMoments<float>> d_splats) override {
    ForwardingBackend::blend_backward(args, d_splats);
    if (d_splats.empty()) return;
    if (strikes(Fault::kMean2d)) d_splats[0].f_d[0] = kNan;
    if (strikes(Fault::kConic)) d_splats[0].f_dd.xx = kNan;
    if (strikes(Fault::kOpacity)) d_splats[0].f = kNan;
    if (strikes(Fault::kColour)) d_splats[0].colour[1] = kNan;
  }
  /// Of the last photometric, whatever has begun since.
  StepOutcome outcome() override {
    StepOutcome outcome = ForwardingBackend::outcome();
    if (loss_is_spoilt_ && !outcome.losses.empty()) outcome.losses[0].total = kNan;
    return outcome;
  }

 private:
  static constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  bool strikes(Fault fault) const { return fault == fault_ && steps_begun_ == step_; }

  Fault fault_;
  int64_t step_, steps_begun_ = 0;
  bool loss_is_spoilt_ = false;
};

}  // namespace tessera::testing
