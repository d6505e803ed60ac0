// The steps of a training at which events are due, and its learning rates, from the options and the
// scene extent. Source: method A.3, A.4, C.1, D.5, D.7.
#pragma once
#include <array>

#include "kernels/gaussians.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// A count of steps that refers to schedule_iterations, scaled to the length of the training.
int64_t scaled_steps(const TrainOptions& options, int64_t steps);

class Schedule {
 public:
  /// `extent`: E, world units (scene_extent).
  Schedule(const TrainOptions& options, double extent);

  /// Steps are counted from 0; these hold before step i.
  int sh_degree(int64_t i) const;
  /// Levels of time: one by one, when all degrees are there.
  int sh_time_degree(int64_t i) const;
  bool densify(int64_t i) const;
  bool gathers_statistics(int64_t i) const { return !is_mcmc() && i < densify_until_; }
  /// Of the Gaussians that a set has room for, the share that the density control before step i may
  /// add: the square root of the share of density controls that are done comes to be filled.
  double growth_share(int64_t i) const;
  bool prunes_large(int64_t i) const { return i > prune_large_from_; }
  bool reset_opacity(int64_t i) const;
  bool reorder(int64_t i) const;
  /// Not before Gaussians are opaque again after a reset of their opacities.
  bool prune_unseen(int64_t i) const;
  /// Whether the parameters after step i are among those that are averaged.
  bool averages(int64_t i) const;
  /// The sizes of the 3D filter: at the start, after density control, and on from its end.
  bool measure_filter(int64_t i) const;
  /// Whether motion nodes start before step i.
  bool start_nodes(int64_t i) const {
    return options_.motion == Motion::kNodes && i == nodes_from_;
  }
  /// Control points of a node at step i, of a clip of so many timesteps.
  int node_knots(int64_t i, int64_t timesteps) const;
  /// Step sizes of log radii, translations and rotations of nodes at step i.
  std::array<AdamScalars<float>, 3> node_adam(int64_t i, int64_t refitted) const;
  /// Learning rate of the means at step i, world units.
  double mean_rate(int64_t i) const;
  /// Learning rate of log gains at step i.
  double exposure_rate(int64_t i) const;
  double clock_rate(int64_t i) const;  // frames
  /// Scale of the means' noise after step i; 0: none (PositionNoise::scale).
  double noise_scale(int64_t i) const { return is_mcmc() ? options_.mcmc_noise * mean_rate(i) : 0; }
  /// Step sizes of step i for a set of that form. `nodes_started`: of a canonical one, the step at
  /// which it became one.
  AdamGroups<float> adam(int64_t i, SetForm form, int64_t nodes_started = 0) const;

 private:
  /// From `rate` to a hundredth of it.
  double resting(double rate, int64_t i) const;
  /// Log-linear from first to last over the whole training.
  double decayed(double first, double last, int64_t i) const;
  int64_t scaled(int64_t steps) const { return scaled_steps(options_, steps); }
  bool is_mcmc() const { return options_.densification == Densification::kMcmc; }

  const TrainOptions options_;
  double extent_;
  int64_t densify_from_, densify_until_, prune_large_from_, sh_interval_;
  int64_t opacity_reset_interval_, reorder_interval_, nodes_from_, node_knot_interval_,
      average_from_;
};

}  // namespace tessera
