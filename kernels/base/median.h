// What: the median of a few numbers.
// Not: other quantiles.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace tessera {

/// The upper of the two in the middle where their number is even. `values` is not empty.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace tessera
