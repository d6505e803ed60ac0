// The groups of a state in their order, and their running means.
#include "recon4d/training/parameter_average.h"

#include <utility>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Calls visit(values) for all that is averaged, always in one order.
template <class State, class Visit>
void for_each_value(State& state, Visit&& visit) {
  for (int k = state.trains(0) ? 0 : 1; k < 2; ++k)
    for (int g = 0; g < state.set(k).groups(); ++g) visit(state.set(k).group(Group(g)).value);
  for (auto* const group : state.model.nodes.groups()) visit(group->value);
}

}  // namespace

void ParameterAverage::add(const TrainState& state) {
  ++states_;
  size_t i = 0;
  for_each_value(state, [&](const Buffer<float>& value) {
    if (i == means_.size()) means_.emplace_back(backend_.memory());
    Buffer<float>& mean = means_[i++];
    if (states_ == 1) {
      mean.resize(value.size());
      backend_.fill_zero(mean.span());
    }
    check(mean.size() == value.size(), "ParameterAverage: of other Gaussians");
    backend_.add_to_mean(value.span(), 1.0f / float(states_), mean.span());
  });
}

void ParameterAverage::take_place(TrainState& state) {
  if (states_ == 0) return;
  size_t i = 0;
  for_each_value(state, [&](Buffer<float>& value) {
    check(means_[i].size() == value.size(), "ParameterAverage: of other Gaussians");
    value = std::move(means_[i++]);
  });
  begin_anew();
}

void ParameterAverage::begin_anew() {
  means_.clear();
  states_ = 0;
}

}  // namespace tessera
