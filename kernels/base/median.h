// What: the number in the middle of some.
// Not: other quantiles (quantile.h).
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace tessera {

/// The upper of the two in the middle where their number is even. `values` is not empty; they
/// change places.
template <class T>
T median_in_place(std::vector<T>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The same of a copy.
template <class T>
T median(std::vector<T> values) {
  return median_in_place(values);
}

/// The lower of the two in the middle where their number is even. `values` is not empty.
template <class T>
T lower_median(std::vector<T> values) {
  const auto middle = values.begin() + std::ptrdiff_t((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace tessera
