// All numbers of a set of Gaussians, to compare sets to the bit.
#pragma once
#include <vector>

#include "recon4d/model/gaussian_set.h"

namespace tessera::testing {

inline std::vector<float> values_of(const GaussianSet& set) {
  std::vector<float> values;
  for (int g = 0; g < set.groups(); ++g) {
    const Span<const float> group = set.group(Group(g)).value.span();
    values.insert(values.end(), group.data, group.data + group.size);
  }
  return values;
}

}  // namespace tessera::testing
