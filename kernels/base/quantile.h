// What: the value below which a share of some numbers lies.
// Not: interpolation between two; the lower one serves.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace tessera {

/// `values` must not be empty; `share` of 0 is the least, of 1 the largest.
inline double quantile(std::vector<double> values, double share) {
  const auto nth = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

}  // namespace tessera
