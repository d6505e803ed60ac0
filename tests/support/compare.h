// Bounds for the difference of an image or a gradient from the truth: per element, over all, and
// for the number of pixels at a cut-off that may differ.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace tessera::testing {

/// Bounds for colours of order 1. A critical pixel sits at a cut-off (α = 1/255, T = 1e-4).
struct ImageBounds {
  double element;   // |difference| of each channel of a pixel that is not critical
  double critical;  // the same for a critical pixel: at most what one faint splat adds
  double budget;    // share of the pixels that may be critical
  double bias;      // |mean signed difference|
};

template <class Actual>
void expect_image(const Actual* actual, const std::vector<double>& expected,
                  const std::vector<bool>& critical, const ImageBounds& bounds, const char* what) {
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

/// Largest |a − b| relative to the largest |b|.
template <class Real>
double relative(const std::vector<Real>& a, const std::vector<Real>& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0, scale = 1e-30;
  for (size_t i = 0; i < a.size() && i < b.size(); ++i) {
    worst = std::max(worst, double(std::abs(a[i] - b[i])));
    scale = std::max(scale, double(std::abs(b[i])));
  }
  return worst / scale;
}

/// Bounds for gradients and other sums of a group: shares of the largest expected value.
struct GroupBounds {
  double element;  // |difference| of all but the outliers
  double outlier;  // the same of the outliers: a pixel at a cut-off decided otherwise
  double budget;   // share of the elements that may be outliers
  double bias;     // |Σ difference| as a share of Σ |expected|
};

template <class Actual, class Expected>
void expect_group(const std::vector<Actual>& actual, const std::vector<Expected>& expected,
                  const GroupBounds& bounds, const std::string& what) {
  ASSERT_EQ(actual.size(), expected.size()) << what;
  double scale = 0, total = 0, sum = 0, worst = 0, outliers = 0;
  for (const Expected e : expected) {
    scale = std::max(scale, std::abs(double(e)));
    total += std::abs(double(e));
  }
  for (size_t i = 0; i < expected.size(); ++i) {
    const double difference = double(actual[i]) - double(expected[i]);
    sum += difference;
    worst = std::isfinite(difference) ? std::max(worst, std::abs(difference)) : INFINITY;
    outliers += !(std::abs(difference) <= bounds.element * scale);
  }
  EXPECT_LE(worst, bounds.outlier * scale) << what << ", largest " << scale;
  EXPECT_LE(outliers, bounds.budget * double(expected.size()))
      << what << ": outliers of " << expected.size() << " elements, worst " << worst / scale;
  EXPECT_LE(std::abs(sum), bounds.bias * total) << what << ": bias";
}

}  // namespace tessera::testing
