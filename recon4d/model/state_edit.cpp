// A state edit is carried out by the operations on blocks of sh_blocks.h, which copy elements as
// they are.
#include "recon4d/model/state_edit.h"

#include "kernels/base/errors.h"
#include "recon4d/model/sh_blocks.h"

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

}  // namespace

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
