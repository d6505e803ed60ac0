// Step counts scaled to the length of the training, and learning rates. All values follow from the
// step alone.
#include "recon4d/training/schedule.h"

#include <algorithm>
#include <cmath>

namespace tessera {

int64_t scaled_steps(const TrainOptions& options, int64_t steps) {
  return std::llround(double(steps) * double(options.iterations) /
                      double(options.schedule_iterations));
}

Schedule::Schedule(const TrainOptions& options, double extent)
    : options_(options),
      extent_(extent),
      densify_from_(scaled(options.densify_from)),
      densify_until_(scaled(options.densify_until)),
      prune_large_from_(scaled(options.prune_large_from)),
      sh_interval_(std::max<int64_t>(1, scaled(options.sh_interval))),
      opacity_reset_interval_(scaled(options.opacity_reset_interval)),
      reorder_interval_(scaled(options.reorder_interval)),
      nodes_from_(scaled(options.nodes_from)),
      node_knot_interval_(std::max<int64_t>(1, scaled(options.node_knot_interval))),
      average_from_(std::llround(options.average_from * double(options.iterations))) {}

int Schedule::sh_degree(int64_t i) const {
  return int(std::min<int64_t>(options_.sh_degree, i / sh_interval_));
}

int Schedule::sh_time_degree(int64_t i) const {
  return int(
      std::clamp<int64_t>(i / sh_interval_ - options_.sh_degree, 0, options_.sh_time_degree));
}

bool Schedule::densify(int64_t i) const {
  return i > 0 && i >= densify_from_ && i <= densify_until_ && i % options_.densify_interval == 0;
}

double Schedule::growth_share(int64_t i) const {
  const int64_t interval = options_.densify_interval;
  const int64_t none = (std::max<int64_t>(densify_from_, 1) - 1) / interval;
  const double all = double(std::max<int64_t>(1, densify_until_ / interval - none));
  const double done = std::clamp(double(i / interval - none), 1.0, all);
  const double before = std::sqrt((done - 1) / all);
  return (std::sqrt(done / all) - before) / (1 - before);
}

bool Schedule::reset_opacity(int64_t i) const {
  if (opacity_reset_interval_ <= 0 || i <= 0 || i >= densify_until_) return false;
  // early on a bright background is modelled by haze; one more reset removes it  [method A.3]
  constexpr int64_t kHazeReset = 500;
  const bool haze = parse_background(options_.background) != std::array<uint8_t, 3>{0, 0, 0} &&
                    i == scaled(kHazeReset);
  return haze || i % opacity_reset_interval_ == 0;
}

bool Schedule::reorder(int64_t i) const {
  // once more after the set has stopped growing
  return reorder_interval_ > 0 && i < densify_until_ + reorder_interval_ &&
         i % reorder_interval_ == 0;
}

bool Schedule::measure_filter(int64_t i) const {
  if (options_.filter_3d == Filter3d::kNone) return false;
  if (i == 0 || densify(i)) return true;
  const int64_t interval = options_.densify_interval;
  return i > densify_until_ && i % interval == 0 && i + interval <= options_.iterations;
}

bool Schedule::averages(int64_t i) const {
  constexpr int64_t kInterval = 5;  // neighbouring steps differ little
  return options_.average_from > 0 && i >= average_from_ && i % kInterval == 0;
}

bool Schedule::prune_unseen(int64_t i) const {
  constexpr int64_t kRecovery = 500;                                  // steps
  if (options_.average_from > 0 && i >= average_from_) return false;  // would begin it anew
  if (options_.min_blending_weight <= 0 || i < std::max<int64_t>(densify_from_, 1)) return false;
  if (i % options_.unseen_interval != 0) return false;
  for (int64_t before = 1; before < std::min(kRecovery, i); ++before)
    if (reset_opacity(i - before)) return false;
  return true;
}

int Schedule::node_knots(int64_t i, int64_t timesteps) const {
  constexpr int64_t kFirst = 5, kTimestepsOfOne = 4;
  const int64_t most = std::clamp(timesteps / kTimestepsOfOne, kFirst, options_.node_knots);
  int64_t knots = kFirst;
  for (int64_t stage = (i - nodes_from_) / node_knot_interval_; stage > 0 && knots < most; --stage)
    knots = 2 * knots - 2;
  return int(std::min(knots, most));
}

std::array<AdamScalars<float>, 3> Schedule::node_adam(int64_t i, int64_t refitted) const {
  const int64_t step = i + 1 - refitted;
  const double decay = decayed(1, options_.lr_node_decay, i);
  return {adam_scalars<float>(options_.lr_node_radius, step),
          adam_scalars<float>(extent_ * options_.lr_node_translation * decay, step),
          adam_scalars<float>(options_.lr_node_rotation * decay, step)};
}

double Schedule::decayed(double first, double last, int64_t i) const {
  if (first == last) return first;
  const double u =
      std::clamp(double(i + 1) / double(std::max<int64_t>(1, options_.iterations)), 0.0, 1.0);
  return std::exp((1 - u) * std::log(std::max(first, 1e-300)) +
                  u * std::log(std::max(last, 1e-300)));
}

double Schedule::mean_rate(int64_t i) const {
  return extent_ * decayed(options_.lr_mean, options_.lr_mean_final, i);
}

double Schedule::resting(double rate, int64_t i) const {
  constexpr double kFinal = 0.01;  // of the rate at the start
  return rate * std::pow(kFinal, double(i + 1) / double(std::max<int64_t>(1, options_.iterations)));
}

double Schedule::exposure_rate(int64_t i) const {
  return resting(options_.lr_exposure, i);
}

double Schedule::clock_rate(int64_t i) const {
  return resting(options_.lr_clocks, i);
}

AdamGroups<float> Schedule::adam(int64_t i, SetForm form, int64_t nodes_started) const {
  const int64_t step = i + 1;
  AdamGroups<float> groups;
  const auto set = [&](Group group, double rate) {
    groups.group[group] = adam_scalars<float>(rate, step);
  };
  set(kMean, mean_rate(i));
  set(kLogScale, options_.lr_scale);
  set(kRotation, options_.lr_rotation);
  set(kOpacityLogit, options_.lr_opacity);
  set(kSh, options_.lr_sh);
  groups.sh_rest = adam_scalars<float>(options_.lr_sh_rest, step);
  if (form == SetForm::kCanonical)
    groups.group[kNodeLogit] = adam_scalars<float>(options_.lr_node_logit, step - nodes_started);
  if (!is_dynamic(form)) return groups;
  set(kMeanTime, extent_ * options_.lr_mean_time);
  set(kLogScaleTime, options_.lr_scale_time);
  if (form == SetForm::kPair)
    set(kRotationRight, options_.lr_rotation);
  else  // a velocity decays as the means do: it moves them
    set(kVelocity, mean_rate(i) * options_.lr_velocity / std::max(options_.lr_mean, 1e-300));
  return groups;
}

}  // namespace tessera
