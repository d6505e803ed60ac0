// The CPU backend with one value changed at one step, as by a faulty kernel or frame.
#pragma once
#include <limits>
#include <memory>

#include "kernels/backend.h"

namespace tessera::testing {

/// Where the NaN goes: into the gradient of the first splat, into that of the first texel of the
/// environment, or into the loss of the first view.
enum class Fault { kMean2d, kConic, kOpacity, kColour, kTexel, kLoss };

class FaultyBackend final : public Backend {
 public:
  /// `step`: counted from 1, as StepReport::iteration.
  FaultyBackend(Fault fault, int64_t step) : fault_(fault), step_(step) {}

  std::string name() const override { return "faulty " + cpu_->name(); }
  Memory& memory() override { return cpu_->memory(); }
  StageClock& clock() override { return cpu_->clock(); }
  void carry(const CarryArgs<float>& args, Carried<float>& carried) override {
    cpu_->carry(args, carried);
  }
  void carry_backward(const CarryBackwardArgs<float>& args) override { cpu_->carry_backward(args); }
  void project(const ProjectArgs<float>& args, Splats<float>& splats) override {
    ++steps_begun_;
    cpu_->project(args, splats);
  }
  void bin(const BinArgs<float>& args, TileInstances<float>& instances) override {
    cpu_->bin(args, instances);
  }
  void blend(const BlendArgs<float>& args, Images<float>& images) override {
    cpu_->blend(args, images);
  }
  void environment(const EnvironmentArgs<float>& args, Images<float>& images) override {
    cpu_->environment(args, images);
  }
  void environment_backward(const EnvironmentArgs<float>& args, const Images<float>& images,
                            Span<const float> d_colour, Span<float> d_map) override {
    cpu_->environment_backward(args, images, d_colour, d_map);
    if (strikes(Fault::kTexel)) d_map[0] = kNan;
  }
  void map_colours(const ColourMapArgs<float>& args, Span<float> mapped) override {
    cpu_->map_colours(args, mapped);
  }
  void map_colours_backward(const ColourMapArgs<float>& args, Span<float> d_colour) override {
    cpu_->map_colours_backward(args, d_colour);
  }
  void photometric(const PhotometricArgs<float>& args, Span<float> d_colour) override {
    cpu_->photometric(args, d_colour);
    loss_is_spoilt_ = strikes(Fault::kLoss);
  }
  void residual(const PhotometricArgs<float>& args, Span<float> residual) override {
    cpu_->residual(args, residual);
  }
  void sensitivity(const SensitivityArgs<float>& args, Span<SplatSensitivity<float>> out) override {
    cpu_->sensitivity(args, out);
  }
  void largest_weights(const BlendArgs<float>& forward, const Images<float>& images,
                       Span<float> elements) override {
    cpu_->largest_weights(forward, images, elements);
  }
  void contributions(const ContributionArgs<float>& args) override { cpu_->contributions(args); }
  void demote(const DemoteArgs<float>& args) override { cpu_->demote(args); }
  void added_squares(const ViewBatch<float>& batch, Span<const float> before,
                     Span<float> residual) override {
    cpu_->added_squares(batch, before, residual);
  }
  void missed_pixels(const MissedArgs<float>& args, Span<uint8_t> missed) override {
    cpu_->missed_pixels(args, missed);
  }
  void residual_votes(const VoteArgs<float>& args, Span<float> votes) override {
    cpu_->residual_votes(args, votes);
  }
  double sum_of_squares(Span<const float> values) override { return cpu_->sum_of_squares(values); }
  void blend_backward(const BlendBackwardArgs<float>& args,
                      Span<SplatMoments<float>> d_splats) override {
    cpu_->blend_backward(args, d_splats);
    if (d_splats.empty()) return;
    if (strikes(Fault::kMean2d)) d_splats[0].f_d[0] = kNan;
    if (strikes(Fault::kConic)) d_splats[0].f_dd.xx = kNan;
    if (strikes(Fault::kOpacity)) d_splats[0].f = kNan;
    if (strikes(Fault::kColour)) d_splats[0].colour[1] = kNan;
  }
  void project_backward(const ProjectBackwardArgs<float>& args) override {
    cpu_->project_backward(args);
  }
  /// Of the last photometric, whatever has begun since.
  StepOutcome outcome() override {
    StepOutcome outcome = cpu_->outcome();
    if (loss_is_spoilt_ && !outcome.losses.empty()) outcome.losses[0].total = kNan;
    return outcome;
  }
  void adam(const SinkArgs<float>& args) override { cpu_->adam(args); }
  void adam_values(Span<const float> gradient, const AdamScalars<float>& adam, Span<float> value,
                   Span<float> moment1, Span<float> moment2) override {
    cpu_->adam_values(gradient, adam, value, moment1, moment2);
  }
  void gather_elements(Span<const float> from, Span<const int64_t> index, int width,
                       int64_t inherited, Span<float> to) override {
    cpu_->gather_elements(from, index, width, inherited, to);
  }
  void select_elements(const GaussianSpans<const float>& set,
                       const DensityStatistics<const float>& statistics, const DensityRule& rule,
                       DensityElements& rows) override {
    cpu_->select_elements(set, statistics, rule, rows);
  }
  double growth_weight(const GaussianSpans<const float>& set,
                       const DensityStatistics<const float>& statistics,
                       const DensityRule& rule) override {
    return cpu_->growth_weight(set, statistics, rule);
  }
  void place_children(const GaussianSpans<float>& set, int64_t first,
                      const SplitRule& rule) override {
    cpu_->place_children(set, first, rule);
  }
  void relocate_elements(const GaussianSpans<float>& set, const RelocationRule& rule,
                         RelocationElements& rows) override {
    cpu_->relocate_elements(set, rule, rows);
  }
  void add_position_noise(const GaussianSpans<float>& set, const PositionNoise& noise) override {
    cpu_->add_position_noise(set, noise);
  }
  void locality_order(const GaussianSpans<const float>& set, Buffer<int64_t>& order) override {
    cpu_->locality_order(set, order);
  }
  void filter_sizes(const FilterArgs<float>& args, Span<float> sizes) override {
    cpu_->filter_sizes(args, sizes);
  }
  void edit_by_filter(FilterEdit edit, const GaussianSpans<float>& set, float limit) override {
    cpu_->edit_by_filter(edit, set, limit);
  }
  void add_to_mean(Span<const float> values, float weight, Span<float> mean) override {
    cpu_->add_to_mean(values, weight, mean);
  }
  void limit_values(Span<float> values, float limit) override { cpu_->limit_values(values, limit); }
  void fill_zero(Span<float> values) override { cpu_->fill_zero(values); }

 private:
  static constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  bool strikes(Fault fault) const { return fault == fault_ && steps_begun_ == step_; }

  std::unique_ptr<Backend> cpu_ = make_cpu_backend();
  Fault fault_;
  int64_t step_, steps_begun_ = 0;
  bool loss_is_spoilt_ = false;
};

}  // namespace tessera::testing
