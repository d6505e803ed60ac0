// Targets of pruning for each kind of request, intermediate cuts, and the remaining SH degrees,
// from known numbers. The order of removal is tested in pruning_test.cpp. Source: failure mode C13.
#include "recon4d/reduction/pruning_choice.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera::testing {
namespace {

/// The images' squared error is 1, so that removals of e in all take 10·log10(1 + e) dB.
Contributions unit_error() {
  Contributions contributions;
  contributions.squared_error = 1;
  contributions.samples = 3000;
  return contributions;
}

/// 100 removals of 10 bytes and the same error.
std::vector<Removal> equal_removals(double error = 0.1) {
  std::vector<Removal> order;
  for (int64_t n = 0; n < 100; ++n) order.push_back({0, n, error, 10});
  return order;
}

PruningChoice chosen(const SizeRequest& request) {
  return choose_pruning(equal_removals(), unit_error(), request);
}

// C13. Bug put back: the goal without its spare; seen to fail.
TEST(PruningChoice, ANumberOfGaussiansAndALittleMore) {
  SizeRequest request{.gaussians = 50};
  EXPECT_EQ(chosen(request).goal, 52) << "1.04 of it";
  EXPECT_EQ(chosen(request).after, 52);
  request.gaussians = 500;
  EXPECT_EQ(chosen(request).goal, 100) << "there are no more";
}

// Bug put back: equal numbers for each round; seen to fail.
TEST(PruningChoice, RoundsTakeEqualRatios) {
  SizeRequest request{.gaussians = 50, .rounds_left = 2};
  EXPECT_EQ(chosen(request).goal, 52);
  EXPECT_EQ(chosen(request).after, 72) << "100·√0.52";
}

// Bug put back: within_db in the place of what the validation views have left; seen to fail.
TEST(PruningChoice, DecibelsThatTheValidationViewsHaveLeft) {
  SizeRequest request{.within_db = 3, .validation_room = 1, .rounds_left = 4};
  const PruningChoice choice = chosen(request);
  EXPECT_EQ(choice.goal, 98) << "two take 0.79 dB, three 1.14 dB";
  EXPECT_EQ(choice.after, 98) << "all the way at each round";
  std::vector<Removal> order = equal_removals();
  order[0].seen = false;
  EXPECT_EQ(choose_pruning(order, unit_error(), request).goal, 98) << "counted as gone";
}

// Bug put back: bytes by the rates alone; seen to fail.
TEST(PruningChoice, BytesScaleFromTheRatesToTheFile) {
  SizeRequest request{.bytes = 1005};
  request.file_bytes = 2000;  // twice the size by the rates
  EXPECT_EQ(chosen(request).goal, 52) << "1040 of 1045 bytes";
}

// Bug put back: the goal computed again where an earlier one is valid; seen to fail.
TEST(PruningChoice, WithoutARequestTheKneeAndThenItsGoal) {
  std::vector<Removal> order = equal_removals();
  for (size_t n = 0; n < order.size(); ++n) order[n].error = n < 60 ? 1e-6 : 0.01 * double(n);
  const PruningChoice choice = choose_pruning(order, unit_error(), {});
  EXPECT_EQ(choice.knee, knee_count(order, unit_error()));
  EXPECT_EQ(choice.goal, choice.knee);
  EXPECT_EQ(choice.after, choice.knee);
  EXPECT_EQ(choice.error_per_byte, error_per_byte_at(order, choice.knee));
  EXPECT_LT(choice.knee, 60);
  SizeRequest later{.known_goal = 77};
  EXPECT_EQ(choose_pruning(order, unit_error(), later).goal, 77);
  EXPECT_EQ(choose_pruning(order, unit_error(), later).knee, choice.knee);
}

// Bug put back: a goal of at least one; seen to fail.
TEST(PruningChoice, OfNoGaussiansNoneIsTheGoal) {
  SizeRequest request{.gaussians = 50};
  const PruningChoice choice = choose_pruning({}, unit_error(), request);
  EXPECT_EQ(choice.goal, 0);
  EXPECT_EQ(choice.after, 0);
}

// Bug put back: a quarter rounded down to none; seen to fail.
TEST(PruningChoice, ACutTakesAQuarterAndAtLeastOne) {
  std::vector<int64_t> cuts;
  for (int64_t now = 100; now > 40;) cuts.push_back(now = next_cut(now, 40));
  EXPECT_EQ(cuts, (std::vector<int64_t>{75, 57, 43, 40}));
  EXPECT_EQ(next_cut(3, 1), 2);
  EXPECT_EQ(next_cut(2, 1), 1);
}

// Bug put back: of equals the highest degree; seen to fail.
TEST(PruningChoice, DegreesThatCostLeast) {
  SetContributions contributions;
  contributions.resize(4);
  // bands of degree 1, 2 and 3 take 4.95, 13.2 and 24.75 bytes
  contributions.truncation_error = {{0, 0, 0}, {100, 100, 1}, {100, 2, 50}, {100, 90, 80}};
  using Degrees = std::vector<uint8_t>;
  const Degrees all(4, 3);
  for (const bool dynamic : {false, true}) {
    EXPECT_EQ(choose_degrees(all, contributions, dynamic, 3, 1), (Degrees{0, 2, 1, 3}));
    EXPECT_EQ(choose_degrees(all, contributions, dynamic, 3, 1000), (Degrees{0, 0, 0, 0}));
    EXPECT_EQ(choose_degrees(all, contributions, dynamic, 3, 0), (Degrees{0, 3, 3, 3}));
  }
  EXPECT_EQ(choose_degrees({1, 1, 2, 0}, contributions, false, 3, 1), (Degrees{0, 1, 1, 0}))
      << "no bands are added";
}

// Bug put back: bands that are not there among the bytes that are saved; seen to fail.
TEST(PruningChoice, OnlyBandsThatAreThereFreeBytes) {
  SetContributions contributions;
  contributions.resize(3);
  contributions.truncation_error = {{10, 0, 0}, {30, 10, 0}, {30, 10, 0}};
  for (const bool dynamic : {false, true}) {
    // degree 1 has 4.95 bytes, degree 2 has 8.25 more, degree 3 another 11.55
    EXPECT_EQ(choose_degrees({1, 2, 3}, contributions, dynamic, 3, 1),
              (std::vector<uint8_t>{1, 2, 2}));
    EXPECT_EQ(choose_degrees({1, 2, 3}, contributions, dynamic, 3, 2.1),
              (std::vector<uint8_t>{0, 1, 1}));
  }
}

}  // namespace
}  // namespace tessera::testing
