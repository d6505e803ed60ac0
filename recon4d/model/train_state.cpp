// Copies of a training state, its model as it is drawn, and edits of its elements by the functions
// of element_edits.h.
#include "recon4d/model/train_state.h"

#include "kernels/base/errors.h"
#include "recon4d/model/element_edits.h"
#include "recon4d/options/train_options.h"

namespace tessera {
namespace {

void drop_elements(Backend& backend, const std::vector<int64_t>& elements, TrainState& state,
                   int k) {
  const std::vector<int64_t> kept = elements_but(state.set(k).count(), elements);
  check(int64_t(kept.size() + elements.size()) == state.set(k).count(),
        "apply_edit: dropped elements that ascend and exist");
  keep_elements(backend, kept, state.set(k), state.statistics[k]);
}

void add_elements(Backend& backend, const GaussianSet& added, TrainState& state, int k) {
  SetStatistics statistics(backend.memory());
  statistics.reset(backend, added.count());
  const bool lies_here = &added.memory() == &backend.memory();
  const GaussianSet copied = lies_here ? added.like() : added.clone_values(backend.memory());
  append_elements(backend, lies_here ? added : copied, statistics, state.set(k),
                  state.statistics[k]);
}

void drop_moments(ParameterGroup& group) {
  group.moment1 = Buffer<float>();
  group.moment2 = Buffer<float>();
}

/// What baked_model reads of a state.
TrainState needed_of(const TrainState& state, const TrainOptions& options) {
  TrainState copy;
  copy.model = state.model.clone_values();
  if (is_filtered(state, options))
    for (int k = 0; k < 2; ++k)
      copy.statistics[k].filter_size.copy_from(state.statistics[k].filter_size);
  return copy;
}

}  // namespace

TrainState TrainState::clone_to(Memory& memory) const {
  return {*this,
          model.clone_to(memory),
          {statistics[0].clone_to(memory), statistics[1].clone_to(memory)},
          exposure.clone(),
          clocks.clone(),
          average.clone_to(memory)};
}

GaussianSpans<float> TrainState::filtered_values(int k) {
  GaussianSpans<float> values = set(k).values();
  values.filter_size = statistics[k].filter_size.span();
  return values;
}

bool is_filtered(const TrainState& state, const TrainOptions& options) {
  return options.filter_3d == Filter3d::kMip && state.has_filter_sizes();
}

GaussianSpans<const float> drawn_values(const TrainState& state, int k,
                                        const TrainOptions& options) {
  GaussianSpans<const float> values = state.set(k).values();
  if (is_filtered(state, options)) values.filter_size = state.statistics[k].filter_size.span();
  return values;
}

GaussianModel baked_model(const TrainState& state, const TrainOptions& options) {
  return baked_model(needed_of(state, options), options);
}

GaussianModel baked_model(TrainState&& state, const TrainOptions& options) {
  const std::unique_ptr<Backend> host = make_cpu_backend();
  const bool filtered = is_filtered(state, options);
  drop_moments(state.model.environment.map);
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    if (filtered) host->edit_by_filter(FilterEdit::kBake, state.filtered_values(k), 0);
    for (int g = 0; g < set.groups(); ++g) drop_moments(set.group(Group(g)));
    if (set.blocks().mixed()) set = padded(set);
  }
  return std::move(state.model);
}

bool StateEdit::empty() const {
  for (int k = 0; k < 2; ++k) {
    if (!dropped[k].empty() || !degrees[k].empty()) return false;
    for (const GaussianSet& set : added[k])
      if (set.count() > 0) return false;
  }
  return true;
}

void apply_edit(Backend& backend, const StateEdit& edit, TrainState& state) {
  for (int k = 0; k < 2; ++k)
    if (!edit.dropped[k].empty()) drop_elements(backend, edit.dropped[k], state, k);
  for (int k = 0; k < 2; ++k)
    for (const GaussianSet& added : edit.added[k]) add_elements(backend, added, state, k);
  for (int k = 0; k < 2; ++k)
    if (!edit.degrees[k].empty())
      set_sh_degrees(backend, edit.degrees[k], state.set(k), state.statistics[k]);
}

}  // namespace tessera
