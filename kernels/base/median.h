// Medians and quantiles of numbers without interpolation, and indices that are spread evenly.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
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

/// `values` must not be empty; `share` of 0 is the least, of 1 the largest.
inline double quantile(std::vector<double> values, double share) {
  const auto nth = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// Number i of `count` numbers that are spread evenly over 0 … total − 1, both ends among them; 0
/// where `count` is 1.
constexpr int64_t even_spread(int64_t i, int64_t count, int64_t total) {
  return count > 1 ? i * (total - 1) / (count - 1) : 0;
}

}  // namespace tessera
