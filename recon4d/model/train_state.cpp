// What: copies of a state, and its SH coefficients brought up to date on the host.
// Not: the arithmetic of catching up (kernels/math/lazy_adam.h).
#include "recon4d/model/train_state.h"

#include <algorithm>

#include "kernels/lazy_schedule.h"
#include "recon4d/model/sh_blocks.h"
#include "recon4d/options/kernel_options.h"

namespace tessera {

TrainState TrainState::clone_to(Memory& memory) const {
  TrainState copy{model.clone_to(memory),
                  {statistics[0].clone_to(memory), statistics[1].clone_to(memory)},
                  exposure.clone()};
  copy.iteration = iteration;
  copy.sampler_epoch = sampler_epoch, copy.sampler_position = sampler_position;
  copy.seconds = seconds, copy.finished = finished;
  copy.decided = decided, copy.goal = goal;
  return copy;
}

GaussianSpans<float> TrainState::filtered_values(int k) {
  GaussianSpans<float> values = set(k).values();
  values.filter_size = statistics[k].filter_size.span();
  return values;
}

bool is_filtered(const TrainState& state, const TrainOptions& options) {
  return options.filter_3d == "mip" && state.has_filter_sizes();
}

GaussianSpans<const float> drawn_values(const TrainState& state, int k,
                                        const TrainOptions& options) {
  GaussianSpans<const float> values = state.set(k).values();
  if (is_filtered(state, options)) values.filter_size = state.statistics[k].filter_size.span();
  return values;
}

LazySh<float> lazy_sh(TrainState& state, int k, const TrainOptions& options,
                      Span<const double> table) {
  if (idle_update(options) != IdleUpdate::kLazy) return {};
  ParameterGroup &sh = state.set(k).group(kSh), &sh_time = state.set(k).group(kShTime);
  return {state.statistics[k].sh_step.span(),
          table,
          sh.value.span(),
          sh.moment1.span(),
          sh.moment2.span(),
          state.iteration,
          float(options.lr_sh),
          float(options.lr_sh_rest),
          sh_time.value.span(),
          sh_time.moment1.span(),
          sh_time.moment2.span(),
          state.set(k).blocks()};
}

bool is_behind(const TrainState& state, const TrainOptions& options) {
  if (idle_update(options) != IdleUpdate::kLazy) return false;
  return std::any_of(state.statistics, state.statistics + 2, [&](const SetStatistics& statistics) {
    return std::any_of(statistics.sh_step.begin(), statistics.sh_step.end(),
                       [&](int32_t step) { return step < state.iteration; });
  });
}

namespace {

void drop_moments(ParameterGroup& group) {
  group.moment1 = Buffer<float>();
  group.moment2 = Buffer<float>();
}

/// What caught_up_model reads of a state.
TrainState needed_of(const TrainState& state, const TrainOptions& options) {
  TrainState copy;
  copy.iteration = state.iteration;
  copy.model = state.model.clone_values();
  const bool filtered = is_filtered(state, options), behind = is_behind(state, options);
  for (int k = 0; k < 2; ++k) {
    if (filtered) copy.statistics[k].filter_size.copy_from(state.statistics[k].filter_size);
    if (!behind) continue;
    copy.statistics[k].sh_step.copy_from(state.statistics[k].sh_step);
    for (const Group g : {kSh, kShTime}) {
      copy.set(k).group(g).moment1.copy_from(state.set(k).group(g).moment1);
      copy.set(k).group(g).moment2.copy_from(state.set(k).group(g).moment2);
    }
  }
  return copy;
}

}  // namespace

GaussianModel caught_up_model(const TrainState& state, const TrainOptions& options) {
  return caught_up_model(needed_of(state, options), options);
}

GaussianModel caught_up_model(TrainState&& state, const TrainOptions& options) {
  const std::unique_ptr<Backend> host = make_cpu_backend();
  const bool filtered = is_filtered(state, options), behind = is_behind(state, options);
  const std::vector<double> table =
      behind ? lazy_adam_table(state.iteration) : std::vector<double>();
  drop_moments(state.model.environment.map);
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    if (filtered) host->edit_by_filter(FilterEdit::kBake, state.filtered_values(k), 0);
    if (behind) host->catch_up(lazy_sh(state, k, options, {table.data(), int64_t(table.size())}));
    for (int g = 0; g < set.groups(); ++g) drop_moments(set.group(Group(g)));
    if (set.blocks().mixed()) set = padded(set);
  }
  return std::move(state.model);
}

}  // namespace tessera
