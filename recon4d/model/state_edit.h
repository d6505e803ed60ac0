// A change of the Gaussians of a training state as a value: elements that go, elements that are
// added and SH degrees. Decisions return it, and `apply_edit` is the only function that carries it
// out.
#pragma once
#include <cstdint>
#include <vector>

#include "recon4d/model/train_state.h"

namespace tessera {

/// Index 0 is the static set, index 1 the dynamic set.
struct StateEdit {
  /// Elements of the set as it is before the edit, ascending.
  std::vector<int64_t> dropped[2];
  /// Sets of the same form, K and L as the set that they join, in any memory; in this order.
  std::vector<GaussianSet> added[2];
  /// [N] SH degree of each element after drops and additions; empty: the degrees stay.
  std::vector<uint8_t> degrees[2];

  /// Whether it changes no element.
  bool empty() const;
};

/// Drops static elements, then dynamic ones, then adds to the static set and to the dynamic set,
/// one added set after the other, and last assigns SH degrees. Kept elements keep their moments and
/// statistics; added ones begin with zeros and without a size of the 3D filter. The state lies in
/// the backend's memory. Errors: std::logic_error: dropped elements that do not ascend or do not
/// exist, added sets of another layout, degrees that are not one for each element or that exceed
/// the element's own.
void apply_edit(Backend& backend, const StateEdit& edit, TrainState& state);

}  // namespace tessera
