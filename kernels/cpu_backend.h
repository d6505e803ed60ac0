// The CPU backend in float (production) and double (reference). Each stage is defined in the file
// of its name in stages/, edits/ or measures/.
#pragma once
#include "kernels/backend.h"

namespace tessera {

template <class Real>
class CpuBackend : public BackendOf<Real> {
 public:
  std::string name() const override;
  Memory& memory() override { return host_memory(); }
  StageClock& clock() override { return clock_; }
  void carry(const CarryArgs<Real>& args, Carried<Real>& carried) override;
  void project(const ProjectArgs<Real>& args, Splats<Real>& splats) override;
  void bin(const BinArgs<Real>& args, TileInstances<Real>& instances) override;
  void blend(const BlendArgs<Real>& args, Images<Real>& images) override;
  void environment(const EnvironmentArgs<Real>& args, Images<Real>& images) override;
  void environment_backward(const EnvironmentArgs<Real>& args, const Images<Real>& images,
                            Span<const Real> d_colour, Span<Real> d_map) override;
  void map_colours(const ColourMapArgs<Real>& args, Span<Real> mapped) override;
  void map_colours_backward(const ColourMapArgs<Real>& args, Span<Real> d_colour) override;
  void photometric(const PhotometricArgs<Real>& args, Span<Real> d_colour) override;
  void residual(const PhotometricArgs<Real>& args, Span<Real> residual) override;
  void blend_backward(const BlendBackwardArgs<Real>& args,
                      Span<SplatMoments<Real>> d_splats) override;
  void sensitivity(const SensitivityArgs<Real>& args, Span<SplatSensitivity<Real>> out) override;
  void largest_weights(const BlendArgs<Real>& forward, const Images<Real>& images,
                       Span<Real> elements) override;
  void contributions(const ContributionArgs<Real>& args) override;
  void demote(const DemoteArgs<Real>& args) override;
  void added_squares(const ViewBatch<Real>& batch, Span<const Real> before,
                     Span<Real> residual) override;
  void missed_pixels(const MissedArgs<Real>& args, Span<uint8_t> missed) override;
  void residual_votes(const VoteArgs<Real>& args, Span<Real> votes) override;
  double sum_of_squares(Span<const Real> values) override;
  void project_backward(const ProjectBackwardArgs<Real>& args) override;
  void carry_backward(const CarryBackwardArgs<Real>& args) override;
  StepOutcome outcome() override { return outcome_; }
  void adam(const SinkArgs<Real>& args) override;
  void adam_values(Span<const Real> gradient, const AdamScalars<Real>& adam, Span<Real> value,
                   Span<Real> moment1, Span<Real> moment2) override;
  void add_to_mean(Span<const Real> values, Real weight, Span<Real> mean) override;
  void gather_elements(Span<const Real> from, Span<const int64_t> index, int width,
                       int64_t inherited, Span<Real> to) override;
  void select_elements(const GaussianSpans<const Real>& set,
                       const DensityStatistics<const Real>& statistics, const DensityRule& rule,
                       DensityElements& elements) override;
  double growth_weight(const GaussianSpans<const Real>& set,
                       const DensityStatistics<const Real>& statistics,
                       const DensityRule& rule) override;
  void place_children(const GaussianSpans<Real>& set, int64_t first,
                      const SplitRule& rule) override;
  void relocate_elements(const GaussianSpans<Real>& set, const RelocationRule& rule,
                         RelocationElements& elements) override;
  void add_position_noise(const GaussianSpans<Real>& set, const PositionNoise& noise) override;
  void locality_order(const GaussianSpans<const Real>& set, Buffer<int64_t>& order) override;
  void filter_sizes(const FilterArgs<Real>& args, Span<Real> sizes) override;
  void edit_by_filter(FilterEdit edit, const GaussianSpans<Real>& set, Real limit) override;
  void limit_values(Span<Real> values, Real limit) override;
  void fill_zero(Span<Real> values) override;

 private:
  HostStageClock clock_;
  StepOutcome outcome_;
  Buffer<Real> environment_parts_;                         // [parts] gradients of a map each
  Buffer<SplatMoments<Real>> instance_gradients_;          // [I] by slot, summed per splat in order
  Buffer<MomentsAndLength<Real>> instance_lengths_;        // likewise, where lengths are wanted
  Buffer<SplatSensitivity<Real>> instance_sensitivities_;  // the same
};

}  // namespace tessera
