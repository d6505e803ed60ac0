// What: Morton codes and time bins.
// Not: a Hilbert curve; Morton is what the reference uses.
#include "recon4d/locality_order.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace tessera {
namespace {

constexpr int kAxisBits = 21;
constexpr int kTimeBins = 32;

/// Bit i of the low 21 bits moves to bit 3·i.
uint64_t spread(uint64_t x) {
  uint64_t result = 0;
  for (int bit = 0; bit < kAxisBits; ++bit) result |= (x >> bit & 1) << (3 * bit);
  return result;
}

uint64_t cell(float value, float low, float side) {
  const float unit = side > 0 ? std::clamp((value - low) / side, 0.0f, 1.0f) : 0.0f;
  return uint64_t(double(unit) * double((1 << kAxisBits) - 1));
}

}  // namespace

std::vector<int64_t> locality_order(const GaussianSet& set) {
  const GaussianSpans<const float> v = set.values();
  constexpr float kMost = std::numeric_limits<float>::max();
  float low[4] = {kMost, kMost, kMost, kMost}, high[4] = {-kMost, -kMost, -kMost, -kMost};
  const auto coordinate = [&](int64_t n, int axis) {
    return axis < 3 ? v.at(kMean, n)[axis] : *v.at(kMeanTime, n);
  };
  const int axes = set.dim();  // 3, or 4 with time
  for (int64_t n = 0; n < set.count(); ++n)
    for (int a = 0; a < axes; ++a) {
      low[a] = std::min(low[a], coordinate(n, a));
      high[a] = std::max(high[a], coordinate(n, a));
    }
  const float side = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  struct Key {
    int bin;
    uint64_t code;
    bool operator<(const Key& other) const {
      return bin != other.bin ? bin < other.bin : code < other.code;
    }
  };
  std::vector<Key> keys(size_t(set.count()), Key{0, 0});
  for (int64_t n = 0; n < set.count(); ++n) {
    Key& key = keys[size_t(n)];
    for (int a = 0; a < 3; ++a) key.code |= spread(cell(coordinate(n, a), low[a], side)) << a;
    if (axes == 4 && high[3] > low[3])
      key.bin = std::min(kTimeBins - 1,
                         int(float(kTimeBins) * (coordinate(n, 3) - low[3]) / (high[3] - low[3])));
  }
  std::vector<int64_t> order(size_t(set.count()));
  std::iota(order.begin(), order.end(), int64_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](int64_t a, int64_t b) { return keys[size_t(a)] < keys[size_t(b)]; });
  return order;
}

}  // namespace tessera
