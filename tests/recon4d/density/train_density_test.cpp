// The Gaussians that density control clones, splits and prunes, their order and their attributes,
// on sets and statistics made by hand. The children of a split are tested in train_split_test.cpp.
// Source: method A.13, D.7.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/recon4d/model/handmade_set.h"

namespace tessera::testing {
namespace {

constexpr double kExtent = 2;  // small: ≤ 0.02; large: > 0.2
constexpr float kSmall = 0.01f, kMedium = 0.1f, kLarge = 0.3f, kHuge = 0.5f;

DensityReport control(HandmadeSet& made, bool prune_large = false, int64_t room = -1,
                      TrainOptions options = {}) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  return control_density(*backend, {options, kExtent, prune_large, room, 7}, made.set,
                         made.statistics);
}

std::vector<Tag> tags(std::initializer_list<int> values) {
  std::vector<Tag> result;
  for (int value : values) result.push_back(Tag(value));
  return result;
}

class Density : public ::testing::TestWithParam<SetForm> {
 protected:
  /// Size, opacity and gradient of each Gaussian; its tag is its place.
  HandmadeSet make(const std::vector<std::array<float, 3>>& elements) {
    HandmadeSet made(GetParam(), int64_t(elements.size()));
    for (size_t n = 0; n < elements.size(); ++n)
      made.describe(int64_t(n), elements[n][0], elements[n][1], elements[n][2]);
    return made;
  }
};
INSTANTIATE_TEST_SUITE_P(Form, Density, ::testing::ValuesIn(kForms),
                         [](const auto& form) { return form_name(form.param); });

constexpr float kWeak = 1e-4f, kStrong = 3e-4f;  // mean gradients about the threshold of 2e-4

TEST_P(Density, CountsAndOrder) {
  HandmadeSet made = make({{kMedium, 0.5f, kWeak},      // 0 stays
                           {kSmall, 0.5f, kStrong},     // 1 cloned
                           {kMedium, 0.5f, kStrong},    // 2 split
                           {kSmall, 0.004f, kStrong},   // 3 pruned, although it would be cloned
                           {kMedium, 0.004f, kStrong},  // 4 pruned, although it would be split
                           {kSmall, 0.5f, kStrong},     // 5 cloned
                           {kLarge, 0.5f, kStrong},     // 6 split; size does not matter yet
                           {kLarge, 0.5f, kWeak}});     // 7 stays
  const DensityReport report = control(made);
  EXPECT_EQ(made.tags(), tags({0, 1, 5, 7, 1, 5, 2, 6, 2, 6}));
  EXPECT_EQ(report.before, 8);
  EXPECT_EQ(report.cloned, 2);
  EXPECT_EQ(report.split, 2);
  EXPECT_EQ(report.pruned, 2);
  EXPECT_EQ(report.after, 10);
  EXPECT_EQ(report.after, report.before + report.cloned + report.split - report.pruned);
}

TEST_P(Density, TheStatisticIsAMean) {
  HandmadeSet made = make({{kSmall, 0.5f, 0}, {kSmall, 0.5f, 0}, {kSmall, 0.5f, 0}});
  made.statistics.gradient_sum[0] = 5 * 2.1e-4f;
  made.statistics.count[0] = 5;  // above
  made.statistics.gradient_sum[1] = 5 * 1.9e-4f;
  made.statistics.count[1] = 5;  // below
  made.statistics.gradient_sum[2] = 0;
  made.statistics.count[2] = 0;  // never seen
  control(made);
  EXPECT_EQ(made.tags(), tags({0, 1, 2, 0}));
  EXPECT_EQ(made.statistics.count.size(), 4);
  EXPECT_EQ(made.statistics.gradient_sum.size(), 4);
  for (int64_t n = 0; n < 4; ++n)
    EXPECT_EQ(made.statistics.count[n] + made.statistics.gradient_sum[n], 0) << "reset";
}

// Bug put back: large Gaussians pruned from the first step; seen to fail.
TEST_P(Density, LargeOnesArePrunedOnlyFromTheirStep) {
  const std::vector<std::array<float, 3>> elements = {{kLarge, 0.5f, kWeak},
                                                      {kLarge, 0.5f, kStrong},
                                                      {kHuge, 0.5f, kStrong},
                                                      {kMedium, 0.5f, kWeak}};
  HandmadeSet early = make(elements), late = make(elements);
  EXPECT_EQ(control(early, false).pruned, 0);
  EXPECT_EQ(early.tags(), tags({0, 3, 1, 2, 1, 2}));
  // children are 1.6 times smaller: 0.1875 stays, 0.3125 is too large still
  const DensityReport report = control(late, true);
  EXPECT_EQ(late.tags(), tags({3, 1, 1}));
  EXPECT_EQ(report.pruned, 2);
  EXPECT_EQ(report.split, 1);
}

TEST_P(Density, DegenerateRotationsArePruned) {
  HandmadeSet made = make({{kMedium, 0.5f, kWeak}, {kMedium, 0.5f, kStrong}, {kSmall, 0.5f, 0}});
  made.set.values().at(kRotation, 1)[0] = 1e-5f;
  for (int k = 1; k < 4; ++k) made.set.values().at(kRotation, 1)[k] = 0;
  EXPECT_EQ(control(made).pruned, 1);
  EXPECT_EQ(made.tags(), tags({0, 2}));
  if (GetParam() != SetForm::kPair) return;
  for (int k = 0; k < 4; ++k) made.set.values().at(kRotationRight, 0)[k] = 0;
  EXPECT_EQ(control(made).pruned, 1);
  EXPECT_EQ(made.tags(), tags({2}));
}

// Bug put back: clones inherit the moments of the original; seen to fail.
TEST_P(Density, ClonesAreCopiesWithoutMoments) {
  HandmadeSet made = make({{kMedium, 0.5f, kWeak}, {kSmall, 0.5f, kStrong}});
  HandmadeSet before = make({{kMedium, 0.5f, kWeak}, {kSmall, 0.5f, kStrong}});
  control(made);
  ASSERT_EQ(made.set.count(), 3);
  for (int g = 0; g < made.set.groups(); ++g) {
    const int width = made.set.width(Group(g));
    const ParameterGroup &now = made.set.group(Group(g)), &old = before.set.group(Group(g));
    ASSERT_EQ(now.moment1.size(), 3 * width);
    for (int k = 0; k < 3 * width; ++k) {
      const int from = k < 2 * width ? k : k - width;  // the third is a copy of the second
      EXPECT_EQ(now.value[k], old.value[from]) << group_name(Group(g), GetParam());
      EXPECT_EQ(now.moment1[k], k < 2 * width ? old.moment1[k] : 0);
      if (packs_moments(Group(g))) continue;
      EXPECT_EQ(now.moment2[k], k < 2 * width ? old.moment2[k] : 0);
    }
  }
}

// Bug put back: the room for new ones counted twice; seen to fail.
TEST_P(Density, TheLimitHoldsAndTheStrongestGrow) {
  std::vector<std::array<float, 3>> elements;
  const float strength[] = {3, 9, 5, 8, 4, 7, 6};
  for (int n = 0; n < 7; ++n)
    elements.push_back({n % 2 == 0 ? kSmall : kMedium, 0.5f, strength[n] * 1e-3f});
  elements.push_back({kSmall, 0.001f, 1});  // makes room for one more
  for (int64_t room = 0; room <= 8; ++room) {
    HandmadeSet made = make(elements);
    const DensityReport report = control(made, false, room);
    EXPECT_EQ(report.after, std::min<int64_t>(8 + room, 14)) << "room for " << room;
    EXPECT_EQ(report.cloned + report.split, std::min<int64_t>(room + 1, 7));
  }
  HandmadeSet made = make(elements);
  control(made, false, 2);  // 9, 8 and 7 are split
  EXPECT_EQ(made.tags(), tags({0, 2, 4, 6, 1, 3, 5, 1, 3, 5}));
}

/// Failure mode C13: as many are pruned as are below, and never one more.
// Bug put back: ≤ in place of ≥ against the limit of opacity; seen to fail. (C13)
TEST_P(Density, PrunesExactlyWhatIsBelow) {
  constexpr int kCount = 400, kBelow = 137;
  std::vector<std::array<float, 3>> elements;
  for (int n = 0; n < kCount; ++n)
    elements.push_back({kMedium, n * 7 % kCount < kBelow ? 0.0049f : 0.0051f, 0});
  HandmadeSet made = make(elements);
  EXPECT_EQ(control(made).pruned, kBelow);
  EXPECT_EQ(made.set.count(), kCount - kBelow);
  EXPECT_EQ(control(made).pruned, 0) << "once is enough";
  std::vector<Tag> in_order = made.tags();
  EXPECT_TRUE(std::is_sorted(in_order.begin(), in_order.end()));
}

TEST_P(Density, AllPrunedAndNoneAtAll) {
  HandmadeSet made = make({{kMedium, 0.001f, 1}, {kSmall, 0.001f, 1}});
  EXPECT_EQ(control(made).after, 0);
  EXPECT_EQ(made.set.count(), 0);
  EXPECT_EQ(control(made).before, 0);
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  reorder(*backend, made.set, made.statistics);
  EXPECT_EQ(prune_invisible(*backend, made.set, made.statistics), 0);
  EXPECT_EQ(made.set.count(), 0);
}

TEST_P(Density, OpacityReset) {
  HandmadeSet made = make({{kMedium, 0.9f, 0}, {kMedium, 0.006f, 0}, {kMedium, 0.01f, 0}});
  const HandmadeSet before = make({{kMedium, 0.9f, 0}, {kMedium, 0.006f, 0}, {kMedium, 0.01f, 0}});
  reset_opacity(*make_cpu_backend(), made.set);
  const ParameterGroup& opacity = made.set.group(kOpacityLogit);
  EXPECT_FLOAT_EQ(opacity.value[0], -4.595119953155518f);
  EXPECT_EQ(opacity.value[1], before.set.group(kOpacityLogit).value[1]) << "lower ones stay";
  for (int64_t n = 0; n < 3; ++n) EXPECT_EQ(opacity.moment1[n] + opacity.moment2[n], 0);
  for (int g = 0; g < made.set.groups(); ++g) {
    if (g == kOpacityLogit) continue;
    const ParameterGroup &now = made.set.group(Group(g)), &old = before.set.group(Group(g));
    EXPECT_TRUE(std::equal(now.value.begin(), now.value.end(), old.value.begin()));
    EXPECT_TRUE(std::equal(now.moment1.begin(), now.moment1.end(), old.moment1.begin()));
  }
}

TEST_P(Density, PruneInvisibleKeepsWhatIsDrawn) {
  HandmadeSet made = make({{kHuge, 0.0038f, 1},  // below 1/255
                           {kHuge, 0.0041f, 1},
                           {kSmall, 0.5f, 1},
                           {kSmall, 0.5f, 1}});
  for (int k = 0; k < 4; ++k) made.set.values().at(kRotation, 2)[k] = 0;
  const float moment = made.set.group(kMean).moment1[3 * 3];
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  EXPECT_EQ(prune_invisible(*backend, made.set, made.statistics), 2);
  EXPECT_EQ(made.tags(), tags({1, 3}));
  EXPECT_EQ(made.set.group(kMean).moment1[3], moment);
  EXPECT_EQ(made.statistics.count.size(), 2);
}

// Bug put back: 0 as the smallest limit instead of none; seen to fail.
TEST_P(Density, ASizeLimitOfZeroIsNone) {
  TrainOptions options;
  for (const auto& [limit, pruned] : {std::pair{0.0, 0}, {1e-30, 2}}) {
    options.prune_extent = limit;
    HandmadeSet made = make({{kSmall, 0.5f, kWeak}, {kLarge, 0.5f, kWeak}});
    EXPECT_EQ(control(made, true, -1, options).pruned, pruned) << limit;
  }
}

/// How often each of three Gaussians with these gradients is split where there is room for one.
std::array<int, 3> draws(const std::array<float, 3>& gradients, int rounds, bool weighted) {
  std::array<int, 3> chosen{};
  TrainOptions options;
  options.densification = Densification::kBudget;
  if (!weighted) options.budget_without = GrowthPart::kWeightedDraw;
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  for (int seed = 0; seed < rounds; ++seed) {
    options.seed = seed;
    HandmadeSet made(SetForm::kStatic, 3);
    for (int64_t n = 0; n < 3; ++n) made.describe(n, kMedium, 0.5f, gradients[size_t(n)]);
    control_density(*backend, {options, kExtent, false, 1, 7}, made.set, made.statistics);
    EXPECT_EQ(made.set.count(), 4);
    ++chosen[size_t(made.tags()[2])];
  }
  return chosen;
}

// Bug put back: −ln(U)·score; seen to fail.
TEST(DensityBudget, WhereRoomIsShortGaussiansAreDrawnByTheirGradients) {
  constexpr int kRounds = 4000;
  const std::array<float, 3> gradients{3e-4f, 6e-4f, 9e-4f};
  const std::array<int, 3> chosen = draws(gradients, kRounds, true);
  for (size_t n = 0; n < 3; ++n) {
    const double p = double(n + 1) / 6;
    EXPECT_NEAR(chosen[n], p * kRounds, 5 * std::sqrt(kRounds * p * (1 - p)));
  }
  EXPECT_EQ(draws(gradients, 5, false), (std::array<int, 3>{0, 0, 5})) << "the strongest";
}

// Bug put back: small ones cloned; seen to fail.
TEST(DensityBudget, HalvesWhateverSizeItHas) {
  TrainOptions options;
  options.densification = Densification::kBudget;
  for (const GrowthPart without : {GrowthPart::kNone, GrowthPart::kLongAxisSplit}) {
    options.budget_without = without;
    HandmadeSet made(SetForm::kStatic, 4);
    made.describe(0, kSmall, 0.5f, kStrong);
    made.describe(1, kMedium, 0.5f, kStrong);
    made.describe(2, kHuge, 0.5f, kWeak);
    made.describe(3, kHuge, 0.004f, kStrong);
    const DensityReport report = control(made, false, -1, options);
    const bool halves = without == GrowthPart::kNone;
    EXPECT_EQ(report.cloned, halves ? 0 : 1);
    EXPECT_EQ(report.split, halves ? 2 : 1);
    EXPECT_EQ(report.pruned, 1);
    EXPECT_EQ(made.set.count(), 5);
  }
}

}  // namespace
}  // namespace tessera::testing
