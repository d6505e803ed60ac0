// The children of a split, which are shrunk copies distributed like their parent, and the order of
// a set for locality. Source: method A.13, A.14, D.7.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/recon4d/model/handmade_set.h"
#include "tests/support/brute_force.h"

namespace tessera::testing {
namespace {

constexpr float kLeft[4] = {0.8f, -0.3f, 0.4f, 0.2f}, kRight[4] = {0.5f, 0.6f, -0.1f, 0.3f};
constexpr double kScale[4] = {0.3, 0.2, 0.6, 0.05};  // t, x, y, z
constexpr float kMeanAt[3] = {1, -2, 3}, kVelocityOf[3] = {0.5f, -1, 0.25f};

/// `count` equal Gaussians that will all be split.
HandmadeSet crowd(SetForm form, int64_t count) {
  HandmadeSet made(form, count);
  for (int64_t n = 0; n < count; ++n) {
    made.describe(n, 1, 0.5f, 1);
    const GaussianSpans<float> v = made.set.values();
    for (int k = 0; k < 3; ++k) {
      v.at(kMean, n)[k] = kMeanAt[k];
      v.at(kLogScale, n)[k] = float(std::log(kScale[k + 1]));
    }
    std::copy_n(kLeft, 4, v.at(kRotation, n));
    if (form == SetForm::kStatic) continue;
    if (form == SetForm::kPair)
      std::copy_n(kRight, 4, v.at(kRotationRight, n));
    else
      std::copy_n(kVelocityOf, 3, v.at(kVelocity, n));
    *v.at(kMeanTime, n) = 0.5f;
    *v.at(kLogScaleTime, n) = float(std::log(kScale[0]));
  }
  return made;
}

void split(HandmadeSet& made, int64_t seed = 1, int64_t step = 7) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  TrainOptions options;
  options.seed = seed;
  const int64_t count = made.set.count();
  const DensityReport report =
      control_density(*backend, {options, 1, false, -1, step}, made.set, made.statistics);
  ASSERT_EQ(report.split, count);
  ASSERT_EQ(report.after, 2 * count);
}

/// Σ on (t, x, y, z) from quaternion products: axes l·e_k·r of length scale_k. With a velocity v,
/// time's axis is σ_t (1, v).
void covariance(SetForm form, double (&sigma)[4][4]) {
  const double left[4] = {kLeft[0], kLeft[1], kLeft[2], kLeft[3]};
  const double right[4] = {kRight[0], kRight[1], kRight[2], kRight[3]};
  const Quaternion l = unit_quaternion(left);
  const Quaternion r =
      form == SetForm::kPair ? unit_quaternion(right) : Quaternion{l[0], -l[1], -l[2], -l[3]};
  for (auto& element : sigma) std::fill(element, element + 4, 0.0);
  for (size_t k = form == SetForm::kStatic ? 1 : 0; k < 4; ++k) {
    Quaternion axis{};
    axis[k] = kScale[k];
    Quaternion image = hamilton(hamilton(l, axis), r);
    for (size_t i = 0; form == SetForm::kVelocity && k == 0 && i < 3; ++i)
      image[i + 1] = kScale[0] * double(kVelocityOf[i]);
    for (size_t i = 0; i < 4; ++i)
      for (size_t j = 0; j < 4; ++j) sigma[i][j] += image[i] * image[j];
  }
}

class SplitForm : public ::testing::TestWithParam<SetForm> {};
INSTANTIATE_TEST_SUITE_P(Form, SplitForm, ::testing::ValuesIn(kForms),
                         [](const auto& form) { return form_name(form.param); });

// Bug put back: the transposed rotation; seen to fail in both dimensions.
TEST_P(SplitForm, ChildrenAreDistributedAsTheirParent) {
  constexpr int64_t kParents = 40000;
  HandmadeSet made = crowd(GetParam(), kParents);
  split(made);
  const GaussianSpans<const float> v = std::as_const(made.set).values();
  double mean[4] = {}, moment[4][4] = {}, sigma[4][4];
  for (int64_t n = 0; n < 2 * kParents; ++n) {
    const float* x = v.at(kMean, n);
    const double offset[4] = {GetParam() != SetForm::kStatic ? *v.at(kMeanTime, n) - 0.5 : 0,
                              x[0] - kMeanAt[0], x[1] - kMeanAt[1], x[2] - kMeanAt[2]};
    for (int i = 0; i < 4; ++i) {
      mean[i] += offset[i] / (2 * kParents);
      for (int j = 0; j < 4; ++j) moment[i][j] += offset[i] * offset[j] / (2 * kParents);
    }
  }
  covariance(GetParam(), sigma);
  for (int i = 0; i < 4; ++i) {
    // five standard errors: σ/√n, and √((σ_ii σ_jj + σ_ij²)/n) of a covariance
    EXPECT_NEAR(mean[i], 0, 5 * std::sqrt(sigma[i][i] / (2 * kParents)) + 1e-12);
    for (int j = 0; j < 4; ++j)
      EXPECT_NEAR(
          moment[i][j], sigma[i][j],
          5 * std::sqrt((sigma[i][i] * sigma[j][j] + sigma[i][j] * sigma[i][j]) / (2 * kParents)) +
              1e-12)
          << i << j;
  }
}

TEST_P(SplitForm, SiblingsDiffer) {
  HandmadeSet made = crowd(GetParam(), 50);
  split(made);
  const Buffer<float>& mean = made.set.group(kMean).value;
  std::vector<float> x;
  for (int64_t n = 0; n < made.set.count(); ++n) x.push_back(mean[3 * n]);
  std::sort(x.begin(), x.end());
  EXPECT_EQ(std::unique(x.begin(), x.end()), x.end()) << "no two children in one place";
  HandmadeSet other_seed = crowd(GetParam(), 50), other_step = crowd(GetParam(), 50);
  split(other_seed, 2);
  split(other_step, 1, 8);
  EXPECT_NE(other_seed.set.group(kMean).value[0], mean[0]);
  EXPECT_NE(other_step.set.group(kMean).value[0], mean[0]);
}

// Bug put back: the temporal scale of children is not shrunk; seen to fail.
TEST_P(SplitForm, ChildrenAreShrunkCopiesWithoutMoments) {
  HandmadeSet made = crowd(GetParam(), 3);
  const HandmadeSet parents = crowd(GetParam(), 3);
  split(made);
  for (int g = 0; g < made.set.groups(); ++g) {
    const Group group = Group(g);
    const int width = made.set.width(group);
    const bool shrinks = group == kLogScale || group == kLogScaleTime;
    const bool moves = group == kMean || group == kMeanTime;
    for (int64_t i = 0; i < 6 * width; ++i) {
      const float old = parents.set.group(group).value[i % (3 * width)];
      const float now = made.set.group(group).value[i];
      if (moves)
        EXPECT_NE(now, old) << group_name(group, GetParam());
      else
        EXPECT_NEAR(now, shrinks ? old - std::log(1.6) : old, shrinks ? 1e-6 : 0)
            << group_name(group, GetParam());
      EXPECT_EQ(made.set.group(group).moment1[i], 0);
      if (packs_moments(group)) continue;
      EXPECT_EQ(made.set.group(group).moment2[i], 0);
    }
  }
}

std::vector<int64_t> locality_order(const GaussianSet& set) {
  Buffer<int64_t> order;
  make_cpu_backend()->locality_order(set.values(), order);
  return {order.begin(), order.end()};
}

/// Bits of the three cells, x lowest, as text from the top: an independent way to compare.
std::string morton_text(const float* p, const float* low, float side) {
  std::string text;
  for (int bit = 20; bit >= 0; --bit)
    for (int axis = 2; axis >= 0; --axis) {
      const double unit = std::clamp<double>((p[axis] - low[axis]) / side, 0, 1);
      text += (int64_t(unit * ((1 << 21) - 1)) >> bit & 1) != 0 ? '1' : '0';
    }
  return text;
}

HandmadeSet scattered(SetForm form, int64_t count) {
  HandmadeSet made(form, count);
  for (int64_t n = 0; n < count; ++n)
    for (int k = 0; k < 3; ++k)
      made.set.values().at(kMean, n)[k] = float(std::fmod(double(n + 1) * (0.37 + 0.211 * k), 2));
  return made;
}

// Bug put back: y and z interleaved in the wrong order; seen to fail.
TEST_P(SplitForm, LocalityOrderIsMortonWithinBinsOfTime) {
  constexpr int64_t kCount = 500;
  HandmadeSet made = scattered(GetParam(), kCount);
  const std::vector<int64_t> order = locality_order(made.set);
  std::vector<int64_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  std::vector<int64_t> all(kCount);
  std::iota(all.begin(), all.end(), int64_t{0});
  ASSERT_EQ(sorted, all) << "a permutation";

  const GaussianSpans<const float> v = std::as_const(made.set).values();
  float low[4] = {9, 9, 9, 9}, high[4] = {-9, -9, -9, -9};
  const auto coordinate = [&](int64_t n, int a) {
    return a < 3 ? v.at(kMean, n)[a] : *v.at(kMeanTime, n);
  };
  for (int64_t n = 0; n < kCount; ++n)
    for (int a = 0; a < dim_of(GetParam()); ++a) {
      low[a] = std::min(low[a], coordinate(n, a));
      high[a] = std::max(high[a], coordinate(n, a));
    }
  const float side = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  const auto bin = [&](int64_t n) {
    if (GetParam() == SetForm::kStatic) return 0;
    return std::min(31, int(32 * (coordinate(n, 3) - low[3]) / (high[3] - low[3])));
  };
  int bins = 0;
  for (size_t i = 1; i < kCount; ++i) {
    const int64_t a = order[i - 1], b = order[i];
    ASSERT_LE(bin(a), bin(b));
    bins += bin(a) != bin(b);
    if (bin(a) != bin(b)) continue;
    ASSERT_LE(morton_text(v.at(kMean, a), low, side), morton_text(v.at(kMean, b), low, side));
  }
  EXPECT_EQ(bins, GetParam() != SetForm::kStatic ? 31 : 0);
}

TEST_P(SplitForm, ReorderMovesEverythingAlong) {
  HandmadeSet made = scattered(GetParam(), 100);
  for (int64_t n = 0; n < 100; ++n) made.describe(n, 0.1f, 0.5f, float(n));
  HandmadeSet before = scattered(GetParam(), 100);
  for (int64_t n = 0; n < 100; ++n) before.describe(n, 0.1f, 0.5f, float(n));
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  reorder(*backend, made.set, made.statistics);
  const std::vector<Tag> tags = made.tags();
  EXPECT_FALSE(std::is_sorted(tags.begin(), tags.end()));
  for (int64_t i = 0; i < 100; ++i) {
    const int64_t from = tags[size_t(i)];
    EXPECT_EQ(made.statistics.gradient_sum[i], before.statistics.gradient_sum[from]);
    EXPECT_EQ(made.statistics.count[i], 3);
    for (int g = 0; g < made.set.groups(); ++g) {
      const int width = made.set.width(Group(g));
      const ParameterGroup &now = made.set.group(Group(g)), &old = before.set.group(Group(g));
      for (int k = 0; k < width; ++k) {
        ASSERT_EQ(now.value[i * width + k], old.value[from * width + k]);
        ASSERT_EQ(now.moment1[i * width + k], old.moment1[from * width + k]);
        if (packs_moments(Group(g))) continue;
        ASSERT_EQ(now.moment2[i * width + k], old.moment2[from * width + k]);
      }
    }
  }
}

TEST_P(SplitForm, EqualPlacesKeepTheirOrder) {
  HandmadeSet made = crowd(GetParam(), 40);
  std::vector<int64_t> expected(40);
  std::iota(expected.begin(), expected.end(), int64_t{0});
  EXPECT_EQ(locality_order(made.set), expected);
}

}  // namespace
}  // namespace tessera::testing
