// Gaussians for the tests of splat formats, and their comparison with what was read back.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "kernels/load_gaussian.h"
#include "static3d/formats/splat_file.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {

/// Whether this build has the library that the format needs.
inline bool is_built([[maybe_unused]] const SplatFormat& format) {
#ifdef TESSERA_HAS_WEBP
  return true;
#else
  return std::string_view(format.name) != "sog";
#endif
}

/// Largest difference of what a file stores, by group.
struct Quanta {
  double mean, log_scale, opacity, colour, sh, rotation;
};

/// Of two quaternions, of which q and −q are the same.
inline double distance(const float* p, const float* q) {
  double plus = 0, minus = 0;
  for (int k = 0; k < 4; ++k) {
    plus += std::pow(double(p[k]) + q[k], 2);
    minus += std::pow(double(p[k]) - q[k], 2);
  }
  return std::sqrt(std::min(plus, minus));
}

/// Rows of a file in the order of `set`: by the nearest mean, which is enough for few Gaussians.
inline std::vector<int64_t> matched(const GaussianSet& set, const GaussianSet& read) {
  std::vector<int64_t> rows;
  for (int64_t n = 0; n < set.count(); ++n) {
    const auto distance = [&](int64_t m) {
      return glm::length(load3(set.values().at(kMean, n)) - load3(read.values().at(kMean, m)));
    };
    int64_t best = 0;
    for (int64_t m = 1; m < read.count(); ++m)
      if (distance(m) < distance(best)) best = m;
    rows.push_back(best);
  }
  return rows;
}

inline void expect_within(const GaussianSet& set, const GaussianSet& read, const Quanta& quanta) {
  ASSERT_EQ(read.count(), set.count());
  const GaussianSpans<const float> a = set.values(), b = read.values();
  const std::vector<int64_t> rows = matched(set, read);
  for (int64_t n = 0; n < set.count(); ++n) {
    const int64_t m = rows[size_t(n)];
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(b.at(kMean, m)[k], a.at(kMean, n)[k], quanta.mean) << n;
      EXPECT_NEAR(b.at(kLogScale, m)[k], a.at(kLogScale, n)[k], quanta.log_scale) << n;
      EXPECT_NEAR(b.at(kSh, m)[k], a.at(kSh, n)[k], quanta.colour) << n;
    }
    EXPECT_NEAR(sigmoid(*b.at(kOpacityLogit, m)), sigmoid(*a.at(kOpacityLogit, n)), quanta.opacity);
    EXPECT_LT(distance(b.at(kRotation, m), a.at(kRotation, n)), quanta.rotation) << n;
    for (int i = 3; i < 3 * std::min(set.coefficients(), read.coefficients()); ++i)
      EXPECT_NEAR(b.at(kSh, m)[i], a.at(kSh, n)[i], quanta.sh) << n;
  }
}

/// Unit quaternions and values that every format can hold.
inline GaussianSet set_to_write(int64_t count) {
  GaussianModel model = random_model(count, 0);
  const GaussianSpans<float> values = model.static_set.values();
  for (int64_t n = 0; n < count; ++n) {
    float* const q = values.at(kRotation, n);
    const float norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; ++k) q[k] /= norm;
    for (int i = 0; i < 48; ++i)
      values.at(kSh, n)[i] = std::clamp(values.at(kSh, n)[i], -0.9f, 0.9f);
  }
  return std::move(model.static_set);
}

}  // namespace tessera::testing
