// What a trainer does to its Gaussians and nodes before a step: growth, pruning, order in memory,
// sizes of the 3D filter, motion nodes.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "kernels/base/seconds_since.h"
#include "recon4d/density/free_space.h"
#include "recon4d/density/mcmc.h"
#include "recon4d/density/unseen.h"
#include "recon4d/motion/nodes.h"
#include "recon4d/training/trainer.h"

namespace tessera {

int64_t Trainer::limit_of_growth() const {
  const int64_t limit = growth_limit(options_), count = state_.model.count();
  if (!grows_with(options_, GrowthPart::kGrowthBudget) || limit <= count) return limit;
  return count + std::llround(schedule_.growth_share(state_.iteration) * double(limit - count));
}

DensityContext Trainer::density_context(int64_t room) const {
  const int64_t i = state_.iteration;
  return {options_, rig_.extent, schedule_.prunes_large(i), room, i};
}

double Trainer::static_share() const {
  const GaussianModel& model = state_.model;
  if (!state_.trains(0)) return 0;
  if (model.dynamic_set.count() == 0) return 1;
  const double by_count = double(model.static_set.count()) / double(model.count());
  if (!grows_with(options_, GrowthPart::kWeightedDraw)) return by_count;
  double weight[2];
  for (int k = 0; k < 2; ++k)
    weight[k] =
        growth_weight(backend_, density_context(-1), state_.set(k), state_.statistics[size_t(k)]);
  const double all = weight[0] + weight[1];
  return all > 0 ? weight[0] / all : by_count;
}

int64_t Trainer::room_of(int k, int64_t limit, double static_share) const {
  if (limit == 0) return -1;
  const int64_t room = std::max<int64_t>(0, limit - state_.model.count());
  // the static set comes first and must leave the dynamic one its share
  return k == 1 ? room : int64_t(static_share * double(room));
}

void Trainer::control() {
  const int64_t i = state_.iteration;
  GaussianModel& model = state_.model;
  const int degree = schedule_.sh_degree(i), time_degree = schedule_.sh_time_degree(i);
  const bool densifies = schedule_.densify(i), reorders = schedule_.reorder(i);
  if (schedule_.prune_unseen(i)) prune_unseen();  // of what the last step left
  if (densifies) prune_free_space();
  control_nodes();
  // The copies of density control and the buffers of a step need not exist at once.
  if (densifies) release_step_buffers();
  model.drawing.sh_degree = degree;
  model.drawing.sh_time_degree = time_degree;
  if (densifies) densify();
  if (densifies || reorders) state_.average.begin_anew();
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state_.set(k);
    if (set.count() == 0 || !state_.trains(k)) continue;
    if (reorders) reorder(backend_, set, state_.statistics[k]);
    if (schedule_.measure_filter(i)) measure_filter(k);
    if (schedule_.reset_opacity(i))
      reset_opacity(
          backend_, set,
          is_filtered(state_, options_) ? state_.statistics[k].filter_size.span() : Span<float>());
  }
}

void Trainer::measure_filter(int k) {
  const StageTimer timer(backend_.clock(), kDensity);
  const ViewBatch<float>& views = filter_views_[k];
  float focal = 0;
  for (const ViewArgs<float>& view : views.views) focal = std::max({focal, view.fl_x, view.fl_y});
  Buffer<float>& sizes = state_.statistics[k].filter_size;
  sizes.resize(state_.set(k).count());
  backend_.filter_sizes({&views, std::as_const(state_).set(k).values(), float(options_.near_plane),
                         focal, float(state_.model.drawing.time_filter)},
                        sizes.span());
}

void Trainer::densify() {
  const int64_t i = state_.iteration;
  const bool mcmc = options_.densification == Densification::kMcmc;
  std::array<DensityReport, 2> reports;
  const int64_t limit = limit_of_growth();
  if (mcmc) reports = control_mcmc(backend_, options_, state_);
  const double of_static = mcmc ? 0 : static_share();
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state_.set(k);
    if (set.count() == 0 || !state_.trains(k)) continue;
    if (!mcmc)
      reports[size_t(k)] = control_density(backend_, density_context(room_of(k, limit, of_static)),
                                           set, state_.statistics[k]);
    observer_.on_density(i, k == 0 ? "static" : "dynamic", reports[size_t(k)]);
  }
}

void Trainer::prune_unseen() {
  constexpr int64_t kEnough = 256;  // frames of a rig, spread over its cameras and timesteps
  complete_pending();               // the pass takes the place of its images
  const auto begin = std::chrono::steady_clock::now();
  const SampledViews sampled =
      views_of_training(scene_, kEnough, state_.iteration / options_.unseen_interval);
  const std::array<DensityReport, 2> reports = tessera::prune_unseen(
      backend_, largest_weights(backend_, pipeline_, forward_args(), sampled, options_.batch),
      options_.min_blending_weight, state_);
  for (int k = 0; k < 2; ++k)
    if (reports[size_t(k)].before > 0)
      observer_.on_density(state_.iteration, k == 0 ? "static" : "dynamic", reports[size_t(k)]);
  unseen_seconds_ += seconds_since(begin);
}

void Trainer::prune_free_space() {
  // where nodes carry a Gaussian is not where it is stored
  if (options_.clear_distance <= 0 || options_.motion == Motion::kNodes) return;
  complete_pending();
  const std::array<DensityReport, 2> reports =
      tessera::prune_free_space(backend_, rig_.cameras, options_.clear_distance, state_);
  for (int k = 0; k < 2; ++k)
    if (reports[size_t(k)].pruned > 0)
      observer_.on_density(state_.iteration, k == 0 ? "static" : "dynamic", reports[size_t(k)]);
}

void Trainer::control_nodes() {
  const int64_t i = state_.iteration;
  GaussianModel& model = state_.model;
  const int knots = schedule_.node_knots(i, timesteps_);
  const bool has_motion = timesteps_ > 1 && options_.motion == Motion::kNodes;
  if (has_motion && schedule_.start_nodes(i) && model.nodes.empty()) {
    complete_pending();
    state_.average.begin_anew();
    Buffer<float> mean, opacity_logit;
    mean.copy_from(model.static_set.group(kMean).value);
    opacity_logit.copy_from(model.static_set.group(kOpacityLogit).value);
    const NodePlan plan =
        plan_nodes(std::as_const(mean).span(), std::as_const(opacity_logit).span(),
                   options_.motion_nodes > 0 ? options_.motion_nodes : kFewNodes);
    start_nodes(backend_, plan, knots, state_);
    gradients_[0] = model.static_set.like(backend_.memory());
  } else if (!model.nodes.empty() && knots > model.nodes.knots) {
    complete_pending();
    state_.average.begin_anew();
    refit_nodes(knots, i, model.nodes);
  }
  if (!model.nodes.empty() &&
      d_nodes_.translation.value.size() != model.nodes.translation.value.size())
    d_nodes_.resize(model.nodes.count, model.nodes.knots);
}

}  // namespace tessera
