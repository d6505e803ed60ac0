// The groups of a state in their order, and their running means.
#include "recon4d/model/parameter_average.h"

#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/model/train_state.h"

namespace tessera {
namespace {

template <class Group, class State>
std::vector<Group*> groups_of(State& state) {
  std::vector<Group*> groups;
  for (int k = state.trains(0) ? 0 : 1; k < 2; ++k)
    for (int g = 0; g < state.set(k).groups(); ++g)
      groups.push_back(&state.set(k).group(tessera::Group(g)));
  for (auto* const group : state.model.nodes.groups()) groups.push_back(group);
  return groups;
}

}  // namespace

void ParameterAverage::begin_anew() {
  *this = {};
}

ParameterAverage ParameterAverage::clone_to(Memory& memory) const {
  ParameterAverage copy{states, {}};
  for (const Buffer<float>& mean : means) copy.means.push_back(mean.clone_to(memory));
  return copy;
}

std::vector<ParameterGroup*> averaged_groups(TrainState& state) {
  return groups_of<ParameterGroup>(state);
}

std::vector<const ParameterGroup*> averaged_groups(const TrainState& state) {
  return groups_of<const ParameterGroup>(state);
}

void add_to_average(Backend& backend, TrainState& state) {
  ParameterAverage& average = state.average;
  ++average.states;
  size_t i = 0;
  for (const ParameterGroup* const group : averaged_groups(std::as_const(state))) {
    if (i == average.means.size()) {
      Buffer<float>& mean = average.means.emplace_back(backend.memory());
      mean.resize(group->value.size());
      backend.fill_zero(mean.span());
    }
    Buffer<float>& mean = average.means[i++];
    check(mean.size() == group->value.size(), "ParameterAverage: of other Gaussians");
    backend.add_to_mean(group->value.span(), 1.0f / float(average.states), mean.span());
  }
}

void take_average(TrainState& state) {
  if (state.average.states == 0) return;
  size_t i = 0;
  for (ParameterGroup* const group : averaged_groups(state)) {
    Buffer<float>& mean = state.average.means[i++];
    check(mean.size() == group->value.size(), "ParameterAverage: of other Gaussians");
    group->value = std::move(mean);
  }
  state.average.begin_anew();
}

}  // namespace tessera
