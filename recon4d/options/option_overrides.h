// What: sets of options put together.
// Not: their application (train_options.h).
#pragma once
#include "recon4d/options/train_options.h"

namespace tessera {

/// `second` after `first`: of a key in both the later holds.
inline OptionOverrides joined(OptionOverrides first, const OptionOverrides& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

}  // namespace tessera
