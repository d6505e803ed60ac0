// Spoils one Gaussian of a random scene and tests that the images and gradients of the others are
// unchanged.
#pragma once
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/render.h"

namespace tessera::testing {

inline constexpr int64_t kVictim = 4;  // of 10 in each set
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kInf = std::numeric_limits<float>::infinity();

inline TestGaussians<float> without_victim(const TestGaussians<float>& set) {
  std::vector<int64_t> rest;
  for (int64_t n = 0; n < set.count; ++n)
    if (n != kVictim) rest.push_back(n);
  return set.select(rest);
}

/// Renders with the victim of one set spoilt, `run` being backward() on some backend: counted once,
/// everything else as if it were not there, forward and backward.
template <class Run>
void expect_culled_and_counted(const TestScene<float>& spoilt, SetForm form, const char* what,
                               Run&& run) {
  TestScene<float> rest = spoilt;
  TestGaussians<float>& set = form == SetForm::kStatic ? rest.fixed : rest.moving;
  set = without_victim(set);
  const Backward<float> a = run(spoilt), b = run(rest);
  EXPECT_EQ(a.rendered.report.invalid_gaussians, 1) << what;
  EXPECT_EQ(a.rendered.colour, b.rendered.colour) << what;
  EXPECT_EQ(a.rendered.transmittance, b.rendered.transmittance) << what;
  EXPECT_EQ(a.bad, 0u) << what;
  const TestGaussians<float>&ga = form == SetForm::kStatic ? a.fixed : a.moving,
        &gb = form == SetForm::kStatic ? b.fixed : b.moving;
  for (int g = 0; g < group_count(form); ++g) {
    EXPECT_EQ(without_victim(ga).group[g], gb.group[g]) << what;
    for (int i = 0; i < group_width(Group(g), 16, form); ++i)
      EXPECT_EQ(ga.at(Group(g), kVictim)[i], 0.0f) << what;
  }
}

}  // namespace tessera::testing
