// What: how a picture of a backend may differ from the truth: per element, over all, and how many
// pixels at a cut-off may decide otherwise. Not: PSNR; these bounds are for equal formulas.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tessera::testing {

/// Bounds for colours of order 1. A critical pixel sits at a cut-off (α = 1/255, T = 1e-4).
struct PictureBounds {
  double element;   // |difference| of each channel of a pixel that is not critical
  double critical;  // the same for a critical pixel: at most what one faint splat adds
  double budget;    // share of the pixels that may be critical
  double bias;      // |mean signed difference|
};

template <class Actual>
void expect_picture(const Actual* actual, const std::vector<double>& expected,
                    const std::vector<bool>& critical, const PictureBounds& bounds,
                    const char* what) {
  double worst = 0, worst_critical = 0, sum = 0, marked = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const size_t pixel = i % critical.size();
    const double difference = double(actual[i]) - expected[i];
    sum += difference;
    double& most = critical[pixel] ? worst_critical : worst;
    most = std::isfinite(difference) ? std::max(most, std::abs(difference)) : INFINITY;
  }
  for (const bool mark : critical) marked += mark;
  EXPECT_LE(worst, bounds.element) << what;
  EXPECT_LE(worst_critical, bounds.critical) << what;
  EXPECT_LE(marked, bounds.budget * double(critical.size())) << what;
  EXPECT_LE(std::abs(sum / double(expected.size())), bounds.bias) << what;
}

}  // namespace tessera::testing
