// Reproducible random numbers and the comparison of the exact tests. The distributions of <random>
// are not used, because their values differ between standard libraries.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

namespace tessera::testing {

class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  /// Uniform in [low, high).
  double uniform(double low, double high) {
    return low + (high - low) * double(engine_() >> 11) * 0x1p-53;
  }
  template <size_t N>
  std::array<double, N> array(double low, double high) {
    std::array<double, N> values;
    for (double& v : values) v = uniform(low, high);
    return values;
  }
  int below(int count) { return int(uniform(0, count)); }

 private:
  std::mt19937_64 engine_;
};

/// Each |actual − expected| ≤ tolerance · max(1, largest |expected|).
template <class A, class B>
void expect_near_all(const A& actual, const B& expected, double tolerance, const char* what) {
  ASSERT_EQ(size_t(std::size(actual)), size_t(std::size(expected))) << what;
  double scale = 1;
  for (const auto& e : expected) scale = std::max(scale, std::abs(double(e)));
  for (size_t i = 0; i < size_t(std::size(actual)); ++i)
    EXPECT_NEAR(double(actual[i]), double(expected[i]), tolerance * scale)
        << what << " [" << i << "]";
}

}  // namespace tessera::testing
