// Prices of motion, results of demotion trials and choices of promotion, from known numbers. The
// measurements are tested in static_demotion_test.cpp and dynamic_promotion_test.cpp.
#include "recon4d/reduction/motion_choice.h"

#include <gtest/gtest.h>

#include <numeric>

namespace tessera::testing {
namespace {

using Indices = std::vector<int64_t>;

// Bug put back: the bytes of a static Gaussian as the price of promotion; seen to fail.
TEST(MotionChoice, PricesFollowFromTheKnee) {
  Contributions contributions;
  contributions.squared_error = 1;
  contributions.samples = 3000;
  std::vector<Removal> order;
  for (int64_t n = 0; n < 60; ++n) order.push_back({0, n, 0.001 * double(n + 1), 10});
  const double slope = error_per_byte_at(order, knee_count(order, contributions));
  ASSERT_GT(slope, 0);
  for (const int degree : {0, 2}) {
    const MotionPrices prices = motion_prices(order, contributions, degree);
    EXPECT_EQ(prices.error_per_byte, slope);
    EXPECT_DOUBLE_EQ(prices.allowed_demotion, 16 * 7.5 * slope) << "bytes of time";
    EXPECT_DOUBLE_EQ(prices.least_promotion, ByteRates().bytes_of(true, degree) * slope);
  }
}

// Bug put back: the sum of the shares as the error of all; seen to fail.
TEST(MotionChoice, AllThatAreAllowedAreAccepted) {
  const DemotionVerdict verdict = judge({{2, 5, 9}, {0.1, 0.2, 0.3}, 1.4, 0.5, false});
  EXPECT_EQ(verdict.accepted, (Indices{2, 5, 9}));
  EXPECT_EQ(verdict.error, 1.4);
  EXPECT_TRUE(verdict.finished);
}

// Bug put back: what equals the allowed error rejected; seen to fail.
TEST(MotionChoice, ThoseAboveTheAllowedErrorAreRejected) {
  const DemotionVerdict verdict = judge({{2, 5, 9}, {0.125, 0.7, 0.5}, 1.325, 0.5, false});
  EXPECT_EQ(verdict.accepted, (Indices{2, 9}));
  EXPECT_EQ(verdict.error, 0.625);
  EXPECT_FALSE(verdict.finished) << "the shares of the others change";
  EXPECT_TRUE(judge({{4}, {1}, 1, 0.5, false}).finished) << "none is left";
}

// Bug put back: finished only when none is rejected; seen to fail.
TEST(MotionChoice, FewRejectedEndTheTrial) {
  for (const int64_t count : {50, 51}) {
    DemotionRound round;
    round.candidates.resize(size_t(count));
    std::iota(round.candidates.begin(), round.candidates.end(), 0);
    round.added_error.assign(size_t(count), 0.25);
    round.added_error[7] = 2;
    round.total = 3;
    round.allowed = 1;
    const DemotionVerdict verdict = judge(round);
    EXPECT_EQ(int64_t(verdict.accepted.size()), count - 1);
    EXPECT_EQ(verdict.finished, count == 51) << "one of fifty";
  }
}

// Bug put back: the half with the larger shares; seen to fail.
TEST(MotionChoice, ErrorInNoShareLeavesTheBetterHalf) {
  DemotionRound round{{1, 4, 6, 8}, {0.5, 0.125, 0.375, 0.25}, 9, 0.5, false};
  const DemotionVerdict half = judge(round);
  EXPECT_EQ(half.accepted, (Indices{4, 8}));
  EXPECT_EQ(half.error, 0.375);
  EXPECT_FALSE(half.finished);
  round.is_last = true;
  const DemotionVerdict none = judge(round);
  EXPECT_EQ(none.accepted, Indices{});
  EXPECT_EQ(none.error, 0);
  EXPECT_TRUE(none.finished);
  round.added_error[2] = 0.75;
  round.total = 1.5;  // allowed for all together
  EXPECT_EQ(judge(round).accepted, (Indices{1, 4, 8}));
  EXPECT_TRUE(judge(round).finished);
}

// Bug put back: as many spawned as promoted; seen to fail.
TEST(MotionChoice, TheLargestGainsArePromotedUpToAShareOfAll) {
  Contributions contributions;  // without noise
  contributions.sets[0].resize(20);
  for (size_t n = 0; n < 20; ++n) {
    contributions.sets[0].change[n].gain = float(n + 1);
    contributions.sets[0].change[n].freedom = 1;
  }
  MotionPrices prices;
  const PromotionChoice choice = choose_promotion(contributions, prices, 100, true);
  EXPECT_EQ(choice.promoted, (Indices{10, 11, 12, 13, 14, 15, 16, 17, 18, 19}));
  EXPECT_EQ(choice.spawned, (Indices{18, 19}));
  prices.least_promotion = 17;
  EXPECT_EQ(choose_promotion(contributions, prices, 100, true).promoted, (Indices{17, 18, 19}));
  EXPECT_EQ(choose_promotion(contributions, prices, 100, false).promoted, Indices{});
  EXPECT_EQ(choose_promotion(contributions, prices, 100, false).spawned, Indices{});
}

}  // namespace
}  // namespace tessera::testing
